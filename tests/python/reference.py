"""What the C++ libraries read (write_reference.cpp), for the tests of python/: TEST.py REFERENCE.json PYTHON_FOLDER."""
import json
import pathlib
import sys

REFERENCE, PYTHON = pathlib.Path(sys.argv[1]), sys.argv[2]
sys.path.insert(0, PYTHON)
import lcmslam_jpeg  # noqa: E402

EXPECTED = json.loads(REFERENCE.read_text())
SAMPLES = str(REFERENCE.parent / "samples.lcmlog")
DRIVE = next(name for name in EXPECTED if name.endswith("kitchen_drive.lcmlog"))
DECODERS = [name for name in ("PIL", "cv2") if getattr(lcmslam_jpeg, name) is not None]
DAMAGED = sorted(name for name in EXPECTED if name not in (SAMPLES, DRIVE))
