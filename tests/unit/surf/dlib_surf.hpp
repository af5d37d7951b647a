#pragma once
// dlib's SURF, the peer, where its headers (libdlib-dev) are installed.

#if __has_include(<dlib/image_keypoint/surf.h>)
#define LCMSLAM_HAS_DLIB
#include <dlib/test_for_odr_violations.h>
// Debian's configuration asks for BLAS and LAPACK, which SURF never calls: without them nothing of dlib
// has to be linked.
#undef DLIB_USE_BLAS
#undef DLIB_USE_LAPACK
#include <dlib/image_keypoint/surf.h>
#include <dlib/opencv/cv_image.h>
#endif
