// A calibration file, or two that go together, with all that they tell.
#pragma once

#include <optional>

#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/cameras/camera_parts.h"

namespace hexrelief::readers::codec {

// Not movable: the parts refer to the text.
struct CameraFile {
    // Reads the files. If one alone is given and lacks what the pair needs, the one beside it is read as well
    // (find_other_file()). Throws Error(input) for what is no calibration.
    CameraFile(const CalibrationSource& source, bool wants_pair);
    CameraFile(const CameraFile&) = delete;
    CameraFile& operator=(const CameraFile&) = delete;

    CalibrationText text;
    std::optional<Calibration> calibration;  // of a format of its own, or
    std::optional<CameraParts> parts;
    std::filesystem::path other;  // the second file that was read; empty = none
};

}  // namespace hexrelief::readers::codec
