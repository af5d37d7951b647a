#pragma once
#include <optional>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

/// CAMERA. seq and sender are the publisher's business (origin.hpp).
images_t to_message(const EncodedFrame& frame);

/// Accepts any images_t with a colour image (LEFT) and a depth image (DEPTH_MM or DEPTH_MM_ZIPPED); throws
/// DecodeError for absurd sizes and unknown formats. The images' bytes are checked by the codec.
EncodedFrame from_message(const images_t& message);
/// A colour image that comes alone, as a bridge sends it; nothing where there is more, or no colour. Throws
/// DecodeError for an image with wrong values.
std::optional<EncodedFrame> picture_alone(const images_t& message);

/// The same with the images decoded; throws DecodeError for bytes that are no such images, and for images
/// that are not of the calibration's size. The depth image is without the calibration's depth_error.
RgbdFrame decode_images(const images_t& message, const RgbdCalibration& calibration);

/// The two steps of it, for those who leave images undecoded: the first checks declared sizes.
EncodedFrame checked_images(const images_t& message, const RgbdCalibration& calibration);
RgbdFrame decode_images(const EncodedFrame& encoded, const RgbdCalibration& calibration);

/// The message has no fields for depth's error and the rolling shutter, and its fields are frozen; the
/// sensor's name carries them: "NAME;depth_error=0.01,0,0.006,1.9,0;rolling_shutter=0.03" (DepthError's in
/// their order; s), the name alone where depth does not err and all rows are of one moment. Logs from before
/// that know the name alone, whatever the camera.
camera_calibration_t to_message(const RgbdCalibration& calibration);
RgbdCalibration from_message(const camera_calibration_t& message);
/// Whether a rolling shutter stands there.
bool tells_rolling_shutter(const camera_calibration_t& message);
/// Whether both say the same of the head (stamps, numbers and senders may differ).
bool same_calibration(camera_calibration_t a, camera_calibration_t b);
/// Whether images of both heads mean the same in their cameras' frames: names and mounts may differ.
bool reads_alike(RgbdCalibration a, RgbdCalibration b);

}  // namespace lcmslam
