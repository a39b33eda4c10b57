#include "pipeline/readers/cameras/calibration_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/cameras/camera_parts.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers {
namespace codec {
namespace {

namespace fs = std::filesystem;

// True if the text is in no notation of entries but in that of a format of its own, which `calibration` gets.
bool parse_own_format(CalibrationText& text, std::optional<Calibration>& calibration) {
    for (const auto parse : {parse_middlebury, parse_kitti, parse_colmap, parse_mvsnet, parse_matrix})
        if ((calibration = parse(text))) return true;
    return false;
}

Entries entries_of(const CalibrationText& text) {
    return text.text.starts_with("PK\3\4") ? npz_entries(text.path) : read_entries(text);
}

[[noreturn]] void refuse_unknown(const fs::path& path, const CalibrationText& text) {
    if (text.text.starts_with("%YAML") || text.text.find("opencv_storage") != std::string::npos)
        refuse_key(
            text, "Q, or P1 and P2,",
            "must be there; save what cv::stereoRectify returned, or give both pictures with K1, D1, K2, "
            "D2, R and T, and they are rectified");
    refuse(path, "not a calibration that is known, which are those of " + family_names());
}

// Returns the entries of both files. If both have a key, the files are those of one camera each.
Entries merged(Entries first, Entries second, const std::string& second_name) {
    const bool are_cameras = std::ranges::any_of(second, [&](const Entry& entry) {
        return entry.side == Side::none && meaning_of(entry) && meaning_of(entry)->part < Part::width &&
               std::ranges::any_of(
                   first, [&](const Entry& one) { return one.side == Side::none && one.key == entry.key; });
    });
    if (are_cameras)
        for (Entry& entry : first)
            if (entry.side == Side::none) entry.side = Side::left;
    for (Entry& entry : second) {
        if (are_cameras && entry.side == Side::none) entry.side = Side::right;
        entry.name = second_name + ": " + entry.name;
        first.push_back(std::move(entry));
    }
    return first;
}

bool is_enough(const CameraParts& parts, bool wants_pair) {
    return parts.is_rectified() || (wants_pair && parts.has_pair() && parts.has_movement());
}

// A calibration file, or two that go together, with all that they tell. Not movable: the parts refer to the
// text.
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

CameraFile::CameraFile(const CalibrationSource& source, bool wants_pair)
    : text(load_calibration_text(source.file)) {
    text.width = source.width;
    text.height = source.height;
    text.views = source.views;
    if (trim(text.text).empty()) refuse(source.file, "the file is empty; give a calibration");
    const bool is_archive = text.text.starts_with("PK\3\4");
    if (!is_archive && parse_own_format(text, calibration)) {
        if (!source.second.empty())
            refuse(source.second, "it does not go with " + source.file.string() + " (" + text.format +
                                      "), which says all; give one calibration");
        return;
    }
    Entries entries = entries_of(text);
    const auto take = [&](const Entries& of_family) {
        const Family* const family = family_of(of_family);
        if (!family) return false;
        Entries selected = family->select ? family->select(text, of_family) : of_family;
        if (family->select) name_sides(selected);
        const bool is_own = std::string_view(family->name) == "hexrelief";
        if (is_own) calibration = own_calibration(text, selected);
        if (is_own)
            text.format = family->name;
        else
            parts.emplace(text, *family, std::move(selected));
        if (family->told && parts) text.told.emplace_back(family->told);
        return true;
    };
    const auto take_with = [&](const fs::path& second) {
        const CalibrationText other_text = load_calibration_text(second);
        Entries both = merged(entries, entries_of(other_text), second.filename().string());
        if (!take(both)) refuse_unknown(source.file, text);
        other = second;
    };
    if (!source.second.empty()) {
        take_with(source.second);
        return;
    }
    const bool is_known = take(entries);
    if (!is_known || (parts && !is_enough(*parts, wants_pair))) {
        const fs::path beside = find_other_file(source.file);
        if (!beside.empty()) {
            text.told.clear();
            take_with(beside);
            if (parts && (is_enough(*parts, wants_pair) || !is_known)) return;
            text.told.clear();
            other.clear();
            take(entries);
        }
    }
    if (!is_known) refuse_unknown(source.file, text);
}

}  // namespace
}  // namespace codec

namespace {

// Refuses a focal length or baseline not above 0 and numbers that are not finite: later stages
// would divide by 0.
void check_possible(const codec::CalibrationText& source, const Calibration& calibration) {
    if (!(calibration.focal_px > 0) || !std::isfinite(calibration.focal_px))
        codec::refuse(source.path,
                      "the focal length is " + number_text(calibration.focal_px) + " px; it must be above 0");
    if (source.has_baseline && (!(calibration.baseline_m > 0) || !std::isfinite(calibration.baseline_m)))
        codec::refuse(source.path, "the baseline is " + number_text(calibration.baseline_m) +
                                       " m; it must be above 0 (left and right swapped?)");
    const bool in_the_middle = std::isnan(calibration.cx) && std::isnan(calibration.cy);
    if (!(in_the_middle || (std::isfinite(calibration.cx) && std::isfinite(calibration.cy))) ||
        !std::isfinite(calibration.doffs_px))
        codec::refuse(source.path, "principal point and disparity offset must be finite numbers");
}

}  // namespace

CalibrationFile read_calibration_file(const CalibrationSource& source) {
    codec::CameraFile file(source, false);
    Calibration calibration = file.parts ? file.parts->rectified() : *file.calibration;
    calibration.metric = file.text.has_baseline;
    check_possible(file.text, calibration);
    return {calibration, file.text.format, file.text.told, file.other,
            file.parts ? file.parts->depth_per_m() : 0};
}

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

std::filesystem::path find_other_file(const std::filesystem::path& file) {
    constexpr std::array pairs = {std::pair{"left", "right"}, std::pair{"Left", "Right"},
                                  std::pair{"LEFT", "RIGHT"}, std::pair{"cam0", "cam1"},
                                  std::pair{"intrinsic", "extrinsic"}};
    const auto with = [](std::string text, const char* from, const char* to) {
        const std::size_t at = text.rfind(from);
        return at == std::string::npos ? std::string() : text.replace(at, std::string(from).size(), to);
    };
    for (const auto& [from, to] : pairs) {
        const std::string name = with(file.filename().string(), from, to);
        const std::string folder = with(file.parent_path().filename().string(), from, to);
        std::filesystem::path other;
        if (!name.empty())
            other = file.parent_path() / name;
        else if (!folder.empty())
            other = file.parent_path().parent_path() / folder / file.filename();
        std::error_code code;
        if (!other.empty() && std::filesystem::is_regular_file(other, code)) return other;
    }
    return {};
}

}  // namespace hexrelief::readers
