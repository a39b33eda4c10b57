#include "pipeline/readers/cameras/stereo_calibration_reader.h"

#include "pipeline/readers/cameras/camera_file.h"

namespace hexrelief::readers {

std::optional<StereoCalibrationFile> read_stereo_calibration(const CalibrationSource& source,
                                                             Rectify rectify) {
    if (rectify == Rectify::never) return std::nullopt;
    codec::CameraFile file(source, true);
    const bool has_pair = file.parts && file.parts->has_pair();
    const bool is_rectified = file.parts && file.parts->is_rectified();
    if (rectify == Rectify::automatic && (!has_pair || (is_rectified && !file.parts->has_movement())))
        return std::nullopt;
    if (!has_pair)
        codec::refuse_key(file.text, "K1, D1, K2, D2, R and T", "must be there to rectify the pair");
    StereoCalibration pair = file.parts->pair();
    return StereoCalibrationFile{std::move(pair), file.text.format, file.text.told, is_rectified, file.other};
}

}  // namespace hexrelief::readers
