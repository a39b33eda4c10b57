// The cameras that a file's entries tell of.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/data/stereo_calibration.h"
#include "pipeline/readers/cameras/key_table.h"
#include "pipeline/readers/cameras/rigid.h"

namespace hexrelief::readers::codec {

// The entries by what they mean. Refuses keys that are given twice with different values.
class CameraParts {
  public:
    // `entries` have keys and sides.
    CameraParts(CalibrationText& source, const Family& family, Entries entries);

    // True if the file tells of the pictures as they were taken: a camera on the right.
    bool has_pair() const;
    // True if it also has the movement between the cameras.
    bool has_movement() const;
    // True if it tells of rectified pictures.
    bool is_rectified() const;

    // Return the cameras of the pictures as they were taken, and of the rectified ones or of one view. Refuse
    // files that lack a part, naming its key.
    StereoCalibration pair();
    Calibration rectified();
    // Returns the integers of the file's depth maps in a metre; 0 = not said.
    double depth_per_m() const;

  private:
    // Returns a clause with the name of the lens's model, if the file has one.
    std::string lens_text() const;
    const Entry* find(Part part, Side side = Side::none) const;
    bool has(Part part, Side side = Side::none) const { return find(part, side) != nullptr; }
    // Returns the numbers of a part that is there; of one count if that is not 0.
    std::vector<double> numbers(Part part, Side side = Side::none, std::size_t count = 0) const;
    double number(Part part, Side side = Side::none) const { return numbers(part, side).at(0); }
    std::pair<int, int> size(Side side) const;
    bool has_camera(Side side) const;
    Side left_side() const;
    std::vector<double> matrix(Side side) const;
    double focal_of_angle(double degrees, int width) const;
    // Returns the camera by its lengths, else by its matrix; the other way round if `matrix_first`.
    Pinhole lengths(Side side, bool matrix_first);
    std::vector<double> distortion(Side side) const;
    StereoCalibration::Camera camera(Side side);
    bool has_rotation() const;
    Rigid movement() const;  // from left to right, m
    bool is_fisheye(const StereoCalibration& pair);
    void tell_of_distortion(Side side);
    Calibration from_q();
    Calibration from_projections_of_both();
    Calibration one_view();

    CalibrationText& source_;
    const Family& family_;
    Entries entries_;
    // By part and side. A second entry of another value is kept to be refused if the part is needed.
    std::map<std::pair<Part, Side>, const Entry*> found_, doubled_;
};

}  // namespace hexrelief::readers::codec
