// The cameras that a file's entries tell of.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/readers/cameras/key_table.h"

namespace hexrelief::readers::codec {

// x becomes rotation x + translation; the rotation is row-major.
struct Rigid {
    std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<double, 3> translation{};
};

inline std::array<double, 9> transposed(const std::array<double, 9>& m) {
    return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
}

// Returns the movement by `first`, then by `then`.
inline Rigid product(const Rigid& then, const Rigid& first) {
    Rigid both;
    const auto &a = then.rotation, &b = first.rotation;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
            both.rotation[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
        both.translation[i] = a[3 * i] * first.translation[0] + a[3 * i + 1] * first.translation[1] +
                              a[3 * i + 2] * first.translation[2] + then.translation[i];
    }
    return both;
}

inline Rigid inverse(const Rigid& a) {
    Rigid back{transposed(a.rotation), {}};
    const Rigid moved = product(back, {{}, a.translation});
    for (std::size_t i = 0; i < 3; ++i) back.translation[i] = -moved.translation[i];
    return back;
}

// Returns the movement of a 4x4 matrix, row-major.
inline Rigid rigid_of(const std::vector<double>& m) {
    return {{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}, {m[3], m[7], m[11]}};
}

// Returns the rotation about a vector, whose length is the angle (Rodrigues).
inline std::array<double, 9> rotation_about(double x, double y, double z) {
    const double angle = std::sqrt(x * x + y * y + z * z);
    if (angle == 0) return {1, 0, 0, 0, 1, 0, 0, 0, 1};
    x /= angle, y /= angle, z /= angle;
    const double c = std::cos(angle), s = std::sin(angle), d = 1 - c;
    return {c + d * x * x,     d * x * y - s * z, d * x * z + s * y, d * x * y + s * z, c + d * y * y,
            d * y * z - s * x, d * x * z - s * y, d * y * z + s * x, c + d * z * z};
}

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
