#include "pipeline/readers/cameras/camera_parts.h"

#include <algorithm>
#include <tuple>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

const double kPi = std::acos(-1.0);

auto depth_of(const Entry& entry) {
    return std::ranges::count(entry.key, '.');
}

}  // namespace

CameraParts::CameraParts(CalibrationText& source, const Family& family, Entries entries)
    : source_(source), family_(family), entries_(std::move(entries)) {
    source.format = family.name;
    for (const Entry& entry : entries_) {
        if (lacks_numbers(entry))
            refuse_key(source, entry.name,
                       "has " + std::to_string(entry.values.size()) +
                           " numbers; K must hold the 9 numbers of a 3x3 matrix, P 12, Q 16" + lens_text());
        const std::optional<Meaning> meaning = meaning_of(entry);
        if (!meaning || meaning->part == Part::model) continue;
        const std::pair place{meaning->part, meaning->side};
        const Entry*& known = found_[place];
        const auto standing = [](const Entry& one) {
            return std::pair(depth_of(one), meaning_of(one)->rank);
        };
        if (!known || standing(entry) < standing(*known)) {
            known = &entry;
            doubled_.erase(place);
        } else if (standing(entry) == standing(*known) && entry.values != known->values) {
            doubled_[place] = &entry;
        }
    }
}

std::string CameraParts::lens_text() const {
    for (const Entry& entry : entries_)
        if (const auto meaning = meaning_of(entry); meaning && meaning->part == Part::model)
            return "; its camera model is " + excerpt(entry.values[0]);
    return {};
}

const Entry* CameraParts::find(Part part, Side side) const {
    const auto found = found_.find({part, side});
    return found == found_.end() ? nullptr : found->second;
}

std::vector<double> CameraParts::numbers(Part part, Side side, std::size_t count) const {
    const Entry& entry = *find(part, side);
    if (const auto other = doubled_.find({part, side}); other != doubled_.end())
        refuse_key(source_, entry.name,
                   other->second->name == entry.name
                       ? "is given twice; keep one"
                       : "and " + other->second->name + " differ; keep the picture's own camera");
    if (count > 0 && entry.values.size() != count)
        refuse_key(source_, entry.name,
                   "has " + std::to_string(entry.values.size()) + " numbers; it must hold " +
                       std::to_string(count) + " numbers");
    return numbers_of(source_, entry);
}

bool CameraParts::has_camera(Side side) const {
    return has(Part::matrix, side) || has(Part::lengths, side) || has(Part::focal, side) ||
           has(Part::fx, side);
}

// The left camera's entries may be those of no side, as in files of one camera.
Side CameraParts::left_side() const {
    return has_camera(Side::left) ? Side::left : Side::none;
}

bool CameraParts::has_pair() const {
    return has_camera(Side::right) || has(Part::distortion, Side::right) ||
           (has_camera(Side::left) && has_movement());
}

bool CameraParts::is_rectified() const {
    return has(Part::q) || (has(Part::projection, Side::left) && has(Part::projection, Side::right)) ||
           has(Part::baseline) || has(Part::baseline_px);
}

std::pair<int, int> CameraParts::size(Side side) const {
    if (side == Side::left && !has(Part::width, side) && !has(Part::size, side)) side = Side::none;
    if (has(Part::width, side) && has(Part::height, side))
        return {require_side(source_, find(Part::width, side)->name, number(Part::width, side)),
                require_side(source_, find(Part::height, side)->name, number(Part::height, side))};
    if (!has(Part::size, side)) return {0, 0};
    const std::vector<double> sides = numbers(Part::size, side);
    const std::string& name = find(Part::size, side)->name;
    const int first = require_side(source_, name, sides[0]), second = require_side(source_, name, sides[1]);
    return family_.is_height_first ? std::pair{second, first} : std::pair{first, second};
}

std::vector<double> CameraParts::matrix(Side side) const {
    std::vector<double> m = numbers(Part::matrix, side);
    if (m.size() != 9 && m.size() != 12 && m.size() != 16)
        refuse_key(
            source_, find(Part::matrix, side)->name,
            "has " + std::to_string(m.size()) + " numbers; it must hold the 9 numbers of a 3x3 matrix");
    return upper_left(m);
}

double CameraParts::focal_of_angle(double degrees, int width) const {
    if (width == 0) width = source_.width;
    if (width == 0)
        refuse_key(source_, "the file", "has an angle of view alone, which needs the size of a picture");
    if (!(degrees > 0 && degrees < 180))
        refuse_key(source_, "the angle of view",
                   "is " + number_text(degrees) + " degrees; it must be below 180");
    return 0.5 * width / std::tan(degrees * kPi / 360);
}

Pinhole CameraParts::lengths(Side side, bool matrix_first) {
    Pinhole camera;
    const auto required = [&](Part part, const char* name) {
        if (!has(part, side))
            refuse_key(source_, name, "is missing; fx, fy, ppx (or cx) and ppy (or cy) go together");
        return number(part, side);
    };
    const auto [width, height] = size(side);
    if (has(Part::matrix, side) && (matrix_first || !has(Part::fx, side))) {
        camera = from_matrix(source_, find(Part::matrix, side)->name, matrix(side));
    } else if (has(Part::fx, side)) {
        const bool is_ppx =
            std::string_view(find(Part::cy, side) ? find(Part::cy, side)->key : "").ends_with("ppy");
        // nerfstudio leaves out what is equal, or the middle.
        const bool may_lack = family_.centre == 0.5;
        camera.fx = number(Part::fx, side);
        camera.fy = may_lack && !has(Part::fy, side) ? camera.fx : required(Part::fy, "fy");
        if (may_lack && !has(Part::cx, side) && !has(Part::cy, side))
            camera.cx = camera.cy = std::nan("");
        else
            camera.cx = required(Part::cx, is_ppx ? "ppx" : "cx"), camera.cy = required(Part::cy, "cy");
    } else if (has(Part::lengths, side)) {
        const std::vector<double> four = numbers(Part::lengths, side);
        camera = {.fx = four[0], .fy = four[1], .cx = four[2], .cy = four[3]};
    } else if (has(Part::focal, side)) {
        const std::vector<double> focal = numbers(Part::focal, side);
        if (!has(Part::centre, side)) refuse_key(source_, "the principal point", "is missing");
        const std::vector<double> centre = numbers(Part::centre, side);
        camera = {.fx = focal.front(), .fy = focal.back(), .cx = centre[0], .cy = centre[1]};
    } else {
        const double degrees = has(Part::fov_x) ? number(Part::fov_x) : number(Part::angle_x) * 180 / kPi;
        camera.fx = camera.fy = focal_of_angle(degrees, width);
        camera.cx = has(Part::cx) ? number(Part::cx) : std::nan("");
        camera.cy = has(Part::cy) ? number(Part::cy) : std::nan("");
    }
    camera.width = width;
    camera.height = height;
    if (width > 0 && std::isnan(camera.cx)) camera.cx = 0.5 * width + family_.centre - kPixelCentre;
    if (height > 0 && std::isnan(camera.cy)) camera.cy = 0.5 * height + family_.centre - kPixelCentre;
    return camera;
}

std::vector<double> CameraParts::distortion(Side side) const {
    if (has(Part::distortion, side)) return numbers(Part::distortion, side);
    if (has(Part::radial, side)) {
        std::vector<double> radial = numbers(Part::radial, side), tangential(2);
        if (has(Part::tangential, side)) tangential = numbers(Part::tangential, side);
        radial.resize(3);
        return {radial[0], radial[1], tangential[0], tangential[1], radial[2]};
    }
    if (!has(Part::k1, side)) return {};
    const auto one = [&](Part part) { return has(part, side) ? number(part, side) : 0; };
    std::vector<double> values = {one(Part::k1), one(Part::k2), one(Part::p1), one(Part::p2), one(Part::k3)};
    if (has(Part::k4, side) && !has(Part::p1, side))  // a fisheye's
        return {one(Part::k1), one(Part::k2), one(Part::k3), one(Part::k4)};
    if (has(Part::k4, side)) values.insert(values.end(), {one(Part::k4), one(Part::k5), one(Part::k6)});
    return values;
}

void CameraParts::tell_of_distortion(Side side) {
    for (const double value : distortion(side))
        if (value != 0) {
            const Entry* const entry = has(Part::distortion, side) ? find(Part::distortion, side)
                                       : has(Part::radial, side)   ? find(Part::radial, side)
                                                                   : find(Part::k1, side);
            source_.told.push_back(entry->name +
                                   " says that the camera distorts; the picture is taken for undistorted");
            return;
        }
}

// Uses Q of cv::stereoRectify: Z = q23 / (q32 d + q33), so 1 / q32 is the baseline and q33 / q32 the offset.
Calibration CameraParts::from_q() {
    const std::vector<double> q = numbers(Part::q, Side::none, 16);
    if (q[14] == 0)
        refuse_key(source_, "Q", "has 0 in row 4, column 3 (1 / baseline): not of a horizontal stereo pair");
    require_one_focal(source_, "Q's row 1 and row 2", q[0], q[5]);
    if (q[0] == 0) refuse_key(source_, "Q", "has 0 in row 1, column 1; it must be 1");
    return {.focal_px = q[11] / q[0],
            .cx = -q[3] / q[0] + kPixelCentre,
            .cy = -q[7] / q[0] + kPixelCentre,
            .baseline_m = q[0] / q[14],
            .doffs_px = q[15] / q[14]};
}

Calibration CameraParts::from_projections_of_both() {
    Projection l{}, r{};
    std::ranges::copy(numbers(Part::projection, Side::left), l.begin());
    std::ranges::copy(numbers(Part::projection, Side::right), r.begin());
    const std::string left = find(Part::projection, Side::left)->name,
                      right = find(Part::projection, Side::right)->name;
    l[0] = require_square(source_, left, l[0], l[5]);
    require_one_focal(source_, left + " and " + right, l[0], r[0]);
    if (l[0] == 0 || r[0] == 0) refuse_key(source_, left + " or " + right, "has the focal length 0");
    if (r[3] == 0 && r[7] != 0)
        refuse_key(source_, right, "is of a vertical pair; only horizontal pairs are read");
    return from_projections(l, r);
}

// Uses P of the rectified picture, else the picture as it was taken.
Calibration CameraParts::one_view() {
    const Side side = has(Part::projection, Side::left) ? Side::left : Side::none;
    const std::vector<double> p =
        has(Part::projection, side) ? numbers(Part::projection, side) : std::vector<double>(12);
    if (p[0] == 0) {
        const Side camera = left_side();
        const bool has_angle = has(Part::fov_x) || has(Part::angle_x);
        if (!has_camera(camera) && !has_angle)
            refuse_key(source_, "fx, fy, cx and cy, or the 9 numbers of K,", "must be there");
        tell_of_distortion(camera);
        const std::string name = has(Part::matrix, camera) && !has(Part::fx, camera)
                                     ? find(Part::matrix, camera)->name
                                     : "fx and fy";
        return from_pinhole(source_, name, lengths(camera, false), kPixelCentre - family_.centre);
    }
    const std::string& name = find(Part::projection, side)->name;
    if (p[7] != 0) refuse_key(source_, name, "is of a vertical pair; only horizontal pairs are read");
    const auto [width, height] = size(side);
    Calibration calibration = from_pinhole(
        source_, name, {.fx = p[0], .fy = p[5], .cx = p[2], .cy = p[6], .width = width, .height = height});
    if (p[3] != 0) {
        source_.has_baseline = true;
        calibration.baseline_m = -p[3] / p[0];
        source_.told.push_back(name +
                               " is of the right camera; its principal point is taken for the left one's");
    }
    return calibration;
}

Calibration CameraParts::rectified() {
    const bool both = has(Part::projection, Side::left) && has(Part::projection, Side::right);
    if (has(Part::q) || both) {
        Calibration calibration = has(Part::q) ? from_q() : from_projections_of_both();
        std::tie(calibration.width, calibration.height) = size(Side::left);
        return calibration;
    }
    const bool has_baseline = has(Part::baseline) || has(Part::baseline_px);
    if (has_pair() && !has_baseline)
        refuse_key(source_, "Q, or P1 and P2,",
                   "must be there for rectified pictures; or give both pictures as they were taken, and they "
                   "are rectified");
    Calibration calibration = one_view();
    if (!has_baseline) return calibration;
    source_.has_baseline = true;
    calibration.baseline_m = has(Part::baseline) ? family_.unit_m * number(Part::baseline)
                                                 : number(Part::baseline_px) / calibration.focal_px;
    return calibration;
}

// BOP's depth_scale is in mm, RealSense's in m, and Open3D's a number of integers in a metre: none of these
// is as large as that of another.
double CameraParts::depth_per_m() const {
    constexpr double most_m = 0.01, most_mm = 100;
    const Part part = has(Part::depth_factor) ? Part::depth_factor : Part::depth_scale;
    if (!has(part)) return 0;
    const double value = number(part);
    if (!(value > 0))
        refuse_key(source_, find(part)->name, "is " + number_text(value) + "; it must be above 0");
    if (part == Part::depth_factor || value >= most_mm) return value;
    return (value < most_m ? 1 : 1000) / value;
}

}  // namespace hexrelief::readers::codec
