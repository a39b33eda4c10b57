#include "tests/fuzz/targets.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "exporters/exporter.h"
#include "pipeline/batch/manifest.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/cameras/exif_focal.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/describe_map.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/photographs/exif.h"
#include "pipeline/readers/photographs/stereo_reader.h"
#include "pipeline/readers/windows/map_windows.h"
#include "tests/temporary_folder.h"

namespace hexrelief::fuzz {
namespace {

namespace fs = std::filesystem;

// Each refuses for itself what it does not like.
template <typename Reader>
void attempt(Reader read) {
    try {
        read();
    } catch (const Error& error) {
        const bool is_line = std::string(error.what()).find('\n') == std::string::npos;
        if (!is_line || (error.kind() != ErrorKind::input && error.kind() != ErrorKind::usage)) throw;
    }
}

// A photograph of a thousand bytes may decode to 16 megapixels, which take their time, the more so here.
constexpr readers::ReaderLimits kLimits{1 << 21};

void read_raster(Bytes bytes, const std::string& name) {
    const fs::path path = file_of(bytes, "");
    const readers::codec::Codec* const codec = readers::codec::find_codec(path);
    const bool is_map = name == "maps";
    if (!codec) return;
    attempt([&] { readers::describe_raster(path, {}, kLimits); });
    attempt([&] { readers::list_contents(path, kLimits); });
    if (is_map) {
        attempt([&] { readers::read_disparity_map(path, {}, kLimits); });
        attempt([&] { readers::read_disparity_map(path, {.key = "[0]", .flip = true}, kLimits); });
        attempt([&] { readers::read_depth_map(path, {.packing = readers::Packing::carla}, kLimits); });
        attempt([&] { readers::read_depth_map(path, {.packing = readers::Packing::tartanair}, kLimits); });
        attempt([&] { readers::read_depth_map(path, {}, kLimits); });
        attempt(
            [&] { readers::read_depth_map(path, {.kind = readers::DepthKind::affine_inverse}, kLimits); });
        attempt([&] { readers::read_confidence(path, {}, kLimits); });
        return;
    }
    attempt([&] { readers::read_image(path, kLimits); });
    attempt([&] { readers::describe_map(path, {}, kLimits); });
    attempt([&] { readers::read_mask(path, {}, kLimits); });
}

void read_stereo(Bytes bytes, const std::string&) {
    const fs::path path = file_of(bytes, "");
    for (const readers::StereoLayout layout :
         {readers::StereoLayout::automatic, readers::StereoLayout::half_side_by_side})
        attempt([&] { readers::read_stereo_file(path, {.layout = layout}, kLimits); });
    attempt([&] { readers::describe_stereo_file(path, kLimits); });
    attempt([&] { readers::list_pictures(path, kLimits); });
    attempt([&] { readers::read_exif_focal(path, 640, 480); });
    attempt([&] { readers::read_orientation(path); });
}

template <typename Windows>
void read_corners(const Windows& file) {
    const int width = std::min(file.width(), 40), height = std::min(file.height(), 40);
    attempt([&] { file.read(0, 0, width, height); });
    file.read(file.width() - width, file.height() - height, width, height);
}

void read_windows(Bytes bytes, const std::string&) {
    attempt([&] { readers::parse_raw_map_layout(std::string(bytes.begin(), bytes.end())); });
    attempt(
        [&] { read_corners(*readers::MapWindows::open(file_of(bytes, ""), {.disparity = {.scale = 1}})); });
    attempt([&] { read_corners(*readers::PictureWindows::open(file_of(bytes, ""), kLimits)); });
}

void read_calibrations(Bytes bytes, const std::string&) {
    const fs::path path = file_of(bytes, "");
    attempt([&] { readers::read_calibration_file(path); });
    attempt([&] { readers::read_calibration_file({path, {}, 640, 480, {"images/000003.png"}}); });
    attempt([&] { readers::read_stereo_calibration(path, readers::Rectify::automatic); });
}

void read_config(Bytes bytes, const std::string&) {
    const std::string text(bytes.begin(), bytes.end());
    config::Config config;
    attempt([&] { config::apply_yaml(config, text, "config", "."); });
    attempt([&] { config::apply_setting(config, text); });
}

// As each kind of manifest, and as lines of options. What is wrong with a row is told in a line, too.
void read_manifests(Bytes bytes, const std::string&) {
    for (const char* const ending : {".yaml", ".csv", ".jsonl", ".txt"})
        attempt([&] {
            const batch::ManifestOptions options{.output = "out",
                                                 .config = {"compact"},
                                                 .depfiles = true,
                                                 .file_options = {"--left", "--right", "--disparity"}};
            for (const batch::BatchUnit& unit : batch::read_manifest(file_of(bytes, ending), options))
                if (unit.wrong.find('\n') != std::string::npos) throw Error(unit.kind, unit.wrong);
        });
}

void describe(Bytes bytes, const std::string& name) {
    attempt([&] { exporters::describe_mesh(file_of(bytes, "." + name)); });
}

}  // namespace

std::string file_of(Bytes bytes, const std::string& extension) {
    static const test::Folder folder;
    const fs::path path = folder.path() / ("unit" + extension);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return path.string();
}

const std::vector<Target>& targets() {
    static const std::vector<Target> all = [] {
        std::vector<Target> list = {
            {"png", read_raster},    {"pnm", read_raster},         {"jpeg", read_raster},
            {"tiff", read_raster},   {"webp", read_raster},        {"bmp", read_raster},
            {"pfm", read_raster},    {"npy", read_raster},         {"npz", read_raster},
            {"exr", read_raster},    {"heic", read_raster},        {"maps", read_raster},
            {"stereo", read_stereo}, {"windows", read_windows},    {"calibration", read_calibrations},
            {"config", read_config}, {"manifest", read_manifests}, {"run", run_whole}};
        for (const exporters::MeshFormat* format : exporters::mesh_formats())
            list.push_back({format->name(), describe});
        return list;
    }();
    return all;
}

const Target& target(const std::string& name) {
    for (const Target& one : targets())
        if (one.name == name) return one;
    throw std::out_of_range("no target " + name);
}

void run(const Target& target, Bytes bytes) {
    try {
        target.run(bytes, target.name);
    } catch (const Error& error) {
        const std::string text = error.what();
        if (text.find('\n') == std::string::npos) return;
        std::fprintf(stderr, "more than a line: %s\n", text.c_str());
        std::abort();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "no Error: %s\n", error.what());
        std::abort();
    }
}

}  // namespace hexrelief::fuzz
