// The cameras of a pair before it is rectified.
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "pipeline/readers/cameras/camera_parts.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

void check_rotation(const CalibrationText& source, const std::array<double, 9>& r) {
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            double product = 0;
            for (std::size_t k = 0; k < 3; ++k) product += r[3 * i + k] * r[3 * j + k];
            if (!(std::abs(product - (i == j ? 1 : 0)) < 0.001))
                refuse_key(source, "R", "is no rotation matrix");
        }
    const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                               r[2] * (r[3] * r[7] - r[4] * r[6]);
    if (determinant < 0) refuse_key(source, "R", "is no rotation matrix: it mirrors");
}

// The names of lens models, in plain_name().
constexpr std::array kFisheyes = {
    "fisheye", "equidistant", "kannalabrandt", "kannalabrandt4", "kannalabrandt8", "kb4", "kb8"};
constexpr std::array kPinholes = {
    "pinhole",      "radtan",      "radialtangential", "plumbbob", "rationalpolynomial",
    "brownconrady", "perspective", "rectified",        "none",     "opencv"};

}  // namespace

StereoCalibration::Camera CameraParts::camera(Side side) {
    const bool is_left = side != Side::right;
    if (!has_camera(side))
        refuse_key(source_, is_left ? "K1" : "K2", "is missing; rectifying a pair needs K1 and K2");
    const Pinhole pinhole = lengths(side, true);
    const std::string name = has(Part::matrix, side) ? find(Part::matrix, side)->name : "a camera";
    if (!(pinhole.fx > 0) || !(pinhole.fy > 0))
        refuse_key(source_, name, "has a focal length that is not above 0");
    if (!std::isfinite(pinhole.cx) || !std::isfinite(pinhole.cy))
        refuse_key(source_, name, "has no principal point");
    StereoCalibration::Camera read;
    read.matrix = {pinhole.fx, 0, pinhole.cx - family_.centre, 0, pinhole.fy, pinhole.cy - family_.centre, 0,
                   0,          1};
    read.distortion = distortion(side);
    if (read.distortion.empty())
        refuse_key(source_, is_left ? "D1" : "D2",
                   "is missing; rectifying a pair needs D1 and D2 (zeros where the lenses do not distort)");
    constexpr std::size_t counts[] = {4, 5, 8, 12, 14};
    if (std::find(std::begin(counts), std::end(counts), read.distortion.size()) == std::end(counts))
        refuse_key(
            source_, find(Part::distortion, side)->name,
            "has " + std::to_string(read.distortion.size()) + " numbers; OpenCV has 4, 5, 8, 12 or 14");
    return read;
}

bool CameraParts::is_fisheye(const StereoCalibration& pair) {
    const bool four = pair.left.distortion.size() == 4 && pair.right.distortion.size() == 4;
    bool is_said = false, says_fisheye = false;
    for (const Entry& entry : entries_) {
        const std::optional<Meaning> meaning = meaning_of(entry);
        if (!meaning || meaning->part != Part::model) continue;
        const std::string model = plain_name(entry.values[0]);
        const bool fisheye = std::find(kFisheyes.begin(), kFisheyes.end(), model) != kFisheyes.end();
        if (!fisheye && std::find(kPinholes.begin(), kPinholes.end(), model) == kPinholes.end())
            refuse_key(
                source_, entry.name,
                "is " + excerpt(entry.values[0]) + "; pinhole and fisheye (equidistant) lenses are read");
        is_said = true;
        says_fisheye |= fisheye;
    }
    if (says_fisheye && !four)
        refuse_key(source_, "D1 or D2", "is not of 4 numbers, as the fisheye model has them");
    if (is_said || !four) return says_fisheye;
    source_.told.emplace_back(
        "4 numbers of distortion are taken for cv::fisheye's; where they are k1, k2, p1, p2, add the line "
        "model: pinhole");
    return true;
}

bool CameraParts::has_rotation() const {
    return has(Part::rotation) || has(Part::transposed) || has(Part::rotation_x) || has(Part::rotation_y) ||
           has(Part::rotation_z);
}

bool CameraParts::has_movement() const {
    const auto both = [&](Part part) { return has(part, Side::left) && has(part, Side::right); };
    const bool moves = has(Part::translation) || has(Part::translation_x);
    return (has_rotation() && moves) || has(Part::transform, Side::right) || has(Part::transform) ||
           has(Part::transform_back) || both(Part::pose) || both(Part::body_to_camera) ||
           (both(Part::rectification) && both(Part::projection));
}

Rigid CameraParts::movement() const {
    const auto matrix = [&](Part part, Side side) { return rigid_of(numbers(part, side, 16)); };
    if (has(Part::transform, Side::right)) return matrix(Part::transform, Side::right);
    if (has(Part::transform)) return matrix(Part::transform, Side::none);
    if (has(Part::transform_back)) return inverse(matrix(Part::transform_back, Side::none));
    if (has(Part::pose, Side::right) && has(Part::pose, Side::left))
        return product(inverse(matrix(Part::pose, Side::right)), matrix(Part::pose, Side::left));
    if (has(Part::body_to_camera, Side::right) && has(Part::body_to_camera, Side::left))
        return product(matrix(Part::body_to_camera, Side::right),
                       inverse(matrix(Part::body_to_camera, Side::left)));
    if (!has_rotation() && has(Part::rectification, Side::left) && has(Part::rectification, Side::right) &&
        has(Part::projection, Side::right)) {
        Rigid left, right;
        std::ranges::copy(numbers(Part::rectification, Side::left), left.rotation.begin());
        std::ranges::copy(numbers(Part::rectification, Side::right), right.rotation.begin());
        const std::vector<double> p = numbers(Part::projection, Side::right);
        if (p[0] == 0)
            refuse_key(source_, find(Part::projection, Side::right)->name, "has the focal length 0");
        left.translation = {p[3] / p[0], p[5] != 0 ? p[7] / p[5] : 0, 0};
        return product(inverse(right), left);
    }
    for (const auto& [name, is_there] :
         {std::pair{"R", has_rotation()}, {"T", has(Part::translation) || has(Part::translation_x)}})
        if (!is_there)
            refuse_key(
                source_, name,
                "is missing; rectifying a pair needs R and T between the cameras, which OpenCV's sample "
                "writes into extrinsics.yml: give both files, each by --calib");
    Rigid moved;
    if (has(Part::translation)) {
        std::ranges::copy(numbers(Part::translation), moved.translation.begin());
    } else {
        for (const Part part : {Part::translation_y, Part::translation_z})
            if (!has(part)) refuse_key(source_, "the translation", "must have x, y and z");
        moved.translation = {number(Part::translation_x), number(Part::translation_y),
                             number(Part::translation_z)};
    }
    for (double& length : moved.translation) length *= family_.unit_m;
    if (has(Part::transposed)) {
        std::ranges::copy(numbers(Part::transposed), moved.rotation.begin());
        moved.rotation = transposed(moved.rotation);
    } else if (has(Part::rotation)) {
        const std::vector<double> r = numbers(Part::rotation);
        if (r.size() == 3)
            moved.rotation = rotation_about(r[0], r[1], r[2]);
        else
            std::ranges::copy(numbers(Part::rotation, Side::none, 9), moved.rotation.begin());
    } else {
        const auto turn = [&](Part part) { return has(part) ? number(part) : 0; };
        moved.rotation =
            rotation_about(turn(Part::rotation_x), turn(Part::rotation_y), turn(Part::rotation_z));
    }
    return moved;
}

StereoCalibration CameraParts::pair() {
    StereoCalibration pair;
    pair.left = camera(left_side());
    pair.right = camera(Side::right);
    const Rigid moved = movement();
    pair.rotation = moved.rotation;
    pair.translation = moved.translation;
    check_rotation(source_, pair.rotation);
    pair.is_fisheye = is_fisheye(pair);
    std::tie(pair.width, pair.height) = size(left_side());
    return pair;
}

}  // namespace hexrelief::readers::codec
