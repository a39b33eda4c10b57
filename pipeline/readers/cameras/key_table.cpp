#include "pipeline/readers/cameras/key_table.h"

#include <algorithm>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// Names in plain_name(). A name without '.' may be the last of the names that lead to a value.
struct KeyRow {
    Part part;
    std::size_t least, most;  // numbers of values
    const char* names;
};

constexpr KeyRow kKeys[] = {
    {Part::matrix, 9, 16,
     "k m cameramatrix intrinsicmatrix intrinsics intrinsic camk mtx cameraintrinsics intrinsicsmatrix"},
    {Part::lengths, 4, 4, "intrinsics intrinsic k cameraintrinsics"},
    {Part::focal, 1, 2, "focallength fc"},
    {Part::centre, 2, 2, "principalpoint cc"},
    {Part::fx, 1, 1, "fx flx fxdepth"},
    {Part::fy, 1, 1, "fy fly fydepth"},
    {Part::cx, 1, 1, "cx ppx u0 mxdepth"},
    {Part::cy, 1, 1, "cy ppy v0 mydepth"},
    {Part::fov_x, 1, 1, "fovx"},
    {Part::angle_x, 1, 1, "cameraanglex"},
    {Part::distortion, 2, 14,
     "d dist distcoeffs distcoeff distortion distortioncoefficients distortioncoeffs distortioncoeff kc "
     "coeffs"},
    {Part::radial, 2, 3, "radialdistortion"},
    {Part::tangential, 2, 2, "tangentialdistortion"},
    {Part::k1, 1, 1, "k1"},
    {Part::k2, 1, 1, "k2"},
    {Part::k3, 1, 1, "k3"},
    {Part::k4, 1, 1, "k4"},
    {Part::k5, 1, 1, "k5"},
    {Part::k6, 1, 1, "k6"},
    {Part::p1, 1, 1, "p1"},
    {Part::p2, 1, 1, "p2"},
    {Part::width, 1, 1, "w width imagewidth nx depthwidth"},
    {Part::height, 1, 1, "h height imageheight ny depthheight"},
    {Part::size, 2, 2, "imagesize size imgsize resolution resolutionleftright"},
    {Part::model, 1, 1, "distortionmodel cameramodel model camera.type"},
    {Part::rectification, 9, 9, "rectificationmatrix"},
    {Part::projection, 12, 12, "projectionmatrix p"},
    {Part::pose, 16, 16, "tbs"},
    {Part::body_to_camera, 16, 16, "tcamimu"},
    {Part::rotation, 3, 9, "r rot rotation rotationmatrix rotationleftright om posecamera2.rotation"},
    {Part::transposed, 9, 9, "rotationofcamera2"},
    {Part::rotation_x, 1, 1, "stereo.rx"},
    {Part::rotation_y, 1, 1, "stereo.cv"},
    {Part::rotation_z, 1, 1, "stereo.rz"},
    {Part::translation, 3, 3,
     "t trans translation translationvector translationofcamera2 translationleftright"},
    {Part::translation_x, 1, 1, "translation.x"},
    {Part::translation_y, 1, 1, "translation.y"},
    {Part::translation_z, 1, 1, "translation.z"},
    {Part::transform, 16, 16, "tcncnm1"},
    {Part::transform_back, 16, 16, "tc1c2"},
    {Part::baseline, 1, 1, "baseline stereo.b"},
    {Part::baseline_px, 1, 1, "camera.bf bf"},
    {Part::q, 16, 16, "q"},
    {Part::depth_scale, 1, 1, "depthscale integerdepthscale"},
    {Part::depth_factor, 1, 1, "depthmapfactor pngdepthscale depthshift camera.scale"},
};

constexpr const char *kRaw = "a pair to rectify", *kRectified = "a rectified pair", *kOne = "one view";

constexpr Family kFamilies[] = {
    {"Middlebury", "`cam0=`, `baseline=` in mm", kRectified, ""},
    {"KITTI", "`P2:` and `P3:`, or one `P_rect_02:`", kRectified, ""},
    {"COLMAP", "`cameras.txt` or `cameras.bin` with one camera", kOne, "", 0.5},
    {"MVSNet", "`extrinsic`, `intrinsic`", kOne, ""},
    {"numbers alone", "3x3, 3x4 or 4x4; `fx fy cx cy`; `w h fx fy cx cy`; nine and a baseline in m", kOne,
     ""},
    {"hexrelief", "`focal_px`, `baseline_m`, `cx`, `cy`, `doffs_px`, `width`, `height`", kRectified,
     "focalpx baselinem", 0.5},
    {"ZED", "sections `LEFT_CAM_HD`, `STEREO`; mm", kRaw,
     "leftcamhd.fx leftcamfhd.fx leftcamvga.fx leftcam2k.fx", 0, -0.001, nullptr, select_zed},
    {"OAK-D", "`cameraData`; cm", kRaw, "cameradata.0.1.intrinsicmatrix", 0, 0.01,
     "its translations are taken as centimetres, as DepthAI writes them", select_oak},
    {"RealSense D400 table", "`rectified.0.fx`, `baseline` in mm", kRectified,
     "rectified.0.fx rectified.1.fx", 0, -0.001, nullptr, select_d400},
    {"RealSense calibration tool", "`FocalLengthLeft`, `TranslationLeftRight` in mm", kRaw,
     "translationleftright", 0, 0.001},
    {"MATLAB", "`CameraParameters1`, `TranslationOfCamera2` in mm", kRaw,
     "radialdistortion translationofcamera2", 1, 0.001,
     "its translation is taken as millimetres, and its first pixel as (1, 1), as MATLAB writes them", nullptr,
     true},
    {"Bouguet's toolbox", "`fc_left`, `om`, `T` in mm", kRaw, "fcleft fc", 0, 0.001},
    {"Kalibr", "`cam0`, `cam1`, `T_cn_cnm1`", kRaw, "tcncnm1 tcamimu"},
    {"EuRoC", "`T_BS`, `intrinsics`, from two files", kRaw, "tbs"},
    {"ORB-SLAM", "`Camera.fx` and `Camera.bf`, or `LEFT.K`, or `Camera1.fx`", kRaw,
     "camera.fx camera1.fx left.k+right.k"},
    {"ROS camera_info", "`camera_matrix` and `projection_matrix`, or `K` and `P`", kRaw,
     "projectionmatrix+cameramatrix p+k"},
    {"OpenCV", "`K1`, `D1`, `K2`, `D2`, `R`, `T`; `Q`, or `P1` and `P2`", kRaw, "q RECTIFIED PAIR"},
    {"nerfstudio and instant-ngp", "`fl_x` or `camera_angle_x`, `w`, `h`", kOne, "flx cameraanglex", 0.5, 1,
     nullptr, select_view},
    {"Cityscapes", "`extrinsic.baseline`, `intrinsic.u0`", kRectified, "u0"},
    {"BOP", "`cam_K`, `depth_scale`", kOne, "camk", 0, 1, nullptr, select_view},
    {"ScanNet", "`fx_depth`, `depthShift`", kOne, "fxdepth"},
    {"MoGe", "`fov_x` in degrees", kOne, "fovx", 0.5},
    {"Open3D intrinsics", "`intrinsic_matrix`", kOne, "intrinsicmatrix"},
    {"RealSense intrinsics", "`fx`, `fy`, `ppx`, `ppy`", kOne, "ppx"},
    {"intrinsics", "`fx`, `fy`, `cx`, `cy`", kOne, "fx"},
    {"camera matrix", "`K`, `camera_matrix` or `intrinsics`", kOne,
     "k m mtx cameramatrix intrinsics intrinsic"},
};

// True if the key is the name, or ends with it.
bool ends_with_name(std::string_view key, std::string_view name) {
    if (!key.ends_with(name)) return false;
    return key.size() == name.size() || key[key.size() - name.size() - 1] == '.';
}

constexpr std::size_t kAnyCount = 0;

std::optional<Meaning> find_key(std::string_view key, std::size_t values, Side side) {
    for (const KeyRow& row : kKeys) {
        if (values != kAnyCount && (values < row.least || values > row.most)) continue;
        int rank = 0;
        for (const std::string_view name : words(row.names)) {
            if (ends_with_name(key, name)) return Meaning{row.part, side, rank};
            ++rank;
        }
    }
    return std::nullopt;
}

// What a key begins or ends with if it names one of two cameras.
struct Affix {
    std::string_view text;
    Side side;
};
constexpr Affix kAffixes[] = {{"left", Side::left}, {"right", Side::right}, {"1", Side::left},
                              {"2", Side::right},   {"l", Side::left},      {"r", Side::right}};

}  // namespace

std::optional<Meaning> meaning_of(const Entry& entry) {
    const std::size_t count = entry.values.size();
    if (count == 0) return std::nullopt;
    std::optional<Meaning> found = find_key(entry.key, count, entry.side);
    if (!found) {
        const std::size_t last = entry.key.rfind('.') + 1;
        const std::string before = entry.key.substr(0, last);
        const std::string_view name = std::string_view(entry.key).substr(last);
        for (const auto& [affix, side] : kAffixes) {
            if (name.size() <= affix.size()) continue;
            const std::string_view stem = name.substr(0, name.size() - affix.size());
            if (name.ends_with(affix)) found = find_key(before + std::string(stem), count, side);
            if (!found && affix.size() > 1 && name.starts_with(affix))
                found = find_key(before + std::string(name.substr(affix.size())), count, side);
            if (found) break;
        }
        if (found && found->part > Part::rotation) return std::nullopt;
    }
    // R of one camera is its rectification, R of both the rotation between them.
    if (found && found->part == Part::rotation && found->side != Side::none && count == 9)
        found->part = Part::rectification;
    return found;
}

bool lacks_numbers(const Entry& entry) {
    if (entry.values.size() < 2 || meaning_of(entry)) return false;
    const std::optional<Meaning> meant = find_key(entry.key, kAnyCount, entry.side);
    // A projection of 4x4 is that of a renderer.
    return meant && (meant->part == Part::matrix || meant->part == Part::q ||
                     (meant->part == Part::projection && entry.values.size() != 16));
}

std::span<const Family> families() {
    return kFamilies;
}

const Family* family_of(const Entries& entries) {
    const auto has_part = [&](Part part, Side side) {
        return std::ranges::any_of(entries, [&](const Entry& entry) {
            const auto meaning = meaning_of(entry);
            return meaning && meaning->part == part && meaning->side == side;
        });
    };
    const auto has = [&](std::string_view mark) {
        if (mark == "q") return has_part(Part::q, Side::none);
        if (mark == "PAIR") return has_part(Part::matrix, Side::left) || has_part(Part::matrix, Side::right);
        if (mark == "RECTIFIED")
            return has_part(Part::projection, Side::left) && has_part(Part::projection, Side::right);
        return std::ranges::any_of(entries, [&](const Entry& entry) {
            const std::string whole = plain_name(entry.name);
            return ends_with_name(entry.key, mark) || ends_with_name(whole, mark);
        });
    };
    const auto has_both = [&](std::string_view mark) {
        const std::size_t plus = mark.find('+');
        return has(mark.substr(0, plus)) && (plus == std::string_view::npos || has(mark.substr(plus + 1)));
    };
    for (const Family& family : kFamilies) {
        const std::vector<std::string_view> marks = words(family.marks);
        if (std::ranges::any_of(marks, has_both)) return &family;
    }
    return nullptr;
}

std::string family_names() {
    return joined(kFamilies, ", ", &Family::name);
}

}  // namespace hexrelief::readers::codec
