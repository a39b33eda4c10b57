// Tests damaged files of every format: each is either read or refused as an input error,
// and nothing else happens.
#include <functional>
#include <random>

#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/depth/sample_maps.h"

namespace hexrelief::readers {
namespace {

constexpr int kMutations = 400;

Bytes noise(std::size_t count) {
    std::mt19937 random(7);
    Bytes bytes(count);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    return bytes;
}

struct Case {
    const char* name;
    Bytes (*make)();
};

const Case kCases[] = {
    {"PngGrey", [] { return make_png(24, 16, noise(384), {}); }},
    {"PngPaletteInterlaced",
     [] {
         return make_png(
             24, 16, noise(384),
             {.colour_type = 3, .interlaced = true, .palette = noise(768), .palette_alpha = noise(9)});
     }},
    {"PngWide", [] { return make_png(24, 16, noise(384 * 8), {.bits = 16, .colour_type = 6}); }},
    {"Pgm", [] { return make_pgm(24, 16, 255, noise(384)); }},
    {"PpmWide", [] { return make_pgm(24, 16, 65535, noise(384 * 6), '6'); }},
    {"Pfm", [] { return make_pfm(24, 16, std::vector<float>(384, 3.25f)); }},
    {"Jpeg", [] { return make_jpeg(24, 16, noise(1152), JpegKind::rgb); }},
    {"JpegProgressive", [] { return make_jpeg(24, 16, noise(1152), JpegKind::rgb_progressive); }},
    {"JpegInks", [] { return make_jpeg(24, 16, noise(1536), JpegKind::cmyk); }},
    {"WebpLossless", [] { return make_webp(24, 16, noise(1536), true); }},
    {"WebpLossy", [] { return make_webp(24, 16, noise(1536), false); }},
    {"TiffPlain", [] { return make_tiff(24, 16, noise(1152), {.samples = 3, .photometric = 2}); }},
    {"TiffLzwTiles", [] { return make_tiff(24, 16, noise(384), {.compression = 5, .tile = 16}); }},
    {"TiffFloatDeflate",
     [] {
         return make_tiff(24, 16, noise(1536),
                          {.bits = 32, .format = 3, .compression = 8, .big_endian = true});
     }},
    {"TiffPalette", [] { return make_tiff(24, 16, noise(384), {.photometric = 3, .compression = 5}); }},
    {"TiffInks", [] { return make_tiff(24, 16, noise(1536), {.samples = 4, .photometric = 5, .tile = 16}); }},
    {"Bmp",
     [] {
         return to_bytes(std::string_view(
                    "BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x18\0\0\0\x10\0\0\0\1\0\x18", 29)) +
                Bytes(25, 0) + noise(1152);
     }},
    {"Npy", [] { return make_npy("<f4", 24, 16, noise(1536)); }},
    {"NpzDeflate",
     [] {
         return make_zip({{"a.npy", make_npy("|u1", 24, 16, noise(384))}}, true);
     }},
    {"NpzStored",
     [] {
         return make_zip({{"a.npy", make_npy("<f2", 24, 16, noise(768))}}, false);
     }},
    {"NpySigned", [] { return make_npy("<i2", 24, 16, noise(768)); }},
    {"ColmapMap", [] { return to_bytes("24&16&1&") + noise(1536); }},
    {"OpenMvsMap",
     [] {
         return Bytes{'D', 'R', 1, 0, 24, 0, 0, 0, 16, 0, 0, 0, 24, 0, 0, 0, 16, 0, 0, 0} + Bytes(8) +
                Bytes{1, 0, 'a', 1, 0, 0, 0, 7, 0, 0, 0} + Bytes(168) + noise(1536);
     }},
    {"SintelMap", [] { return to_bytes("PIEH") + Bytes{24, 0, 0, 0, 16, 0, 0, 0} + noise(1536); }},
    {"TiffSigned", [] { return make_tiff(24, 16, noise(768), {.bits = 16, .format = 2, .compression = 5}); }},
#ifdef HEXRELIEF_HAS_OPENEXR
    {"Exr",
     [] {
         return make_exr(24, 16, {{"Z", std::vector<float>(384, 3.25f)}});
     }},
    {"ExrZipTiles",
     [] {
         return make_exr(24, 16, {{"Z", std::vector<float>(384, 3.25f)}}, {.zip = true, .tile = 10});
     }},
#endif
    {"Middlebury",
     [] {
         return to_bytes(
             "cam0=[ 713.189 0 356.021 ; 0 713.189 238.263 ; 0 0 1 ]\n baseline= 178.089\ndoffs= 31.34\n"
             "width= 707\r\nheight=481 # comment\n");
     }},
    {"Kitti",
     [] {
         return to_bytes(
             "P2: 721.5 0 609.6 44.9 0 721.5 172.9 0.2 0 0 1 0.003\n"
             "P3: 721.5 0 609.6 -339.5 0 721.5 172.9 2.2 0 0 1 0.003\n");
     }},
    {"OpenCv",
     [] {
         return to_bytes(
             "%YAML:1.0\n---\nQ: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [ 1., 0., 0., "
             "-320., 0., 1., 0.,\n       -240., 0., 0., 0., 500., 0., 0., 10., 0. ]\n");
     }},
    {"StereoPair",
     [] {
         return to_bytes(
             "%YAML:1.0\n---\nimage_size: [ 640, 480 ]\nK1: [5., 0., 3., 0., 5., 2., 0., 0., 1.]\n"
             "K2: [5., 0., 3., 0., 5., 2., 0., 0., 1.]\nD1: [0.1, 0., 0., 0.]\nD2: [0., 0., 0., 0., 0.1]\n"
             "R: [1., 0., 0., 0., 1., 0., 0., 0., 1.]\nT: [-0.1, 0., 0.]\nmodel: pinhole\n");
     }},
    {"Xml",
     [] {
         return to_bytes(
             "<opencv_storage><K type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>700 0 "
             "320 0 "
             "700 240 0 0 1</data></K></opencv_storage>");
     }},
    {"Assigned", [] { return to_bytes("fc = [ 700 ; 701 ];\ncc = [ 320 ; 240 ];\nnx = 640;\nny = 480;\n"); }},
    {"Kalibr",
     [] {
         return to_bytes(
             "cam0:\n  intrinsics: [700, 700, 320, 240]\n  distortion_coeffs: [0, 0, 0, 0]\ncam1:\n  "
             "intrinsics: "
             "[700, 700, 320, 240]\n  distortion_coeffs: [0, 0, 0, 0]\n  T_cn_cnm1: [1, 0, 0, -1, 0, 1, 0, "
             "0, 0, 0, "
             "1, 0, 0, 0, 0, 1]\n");
     }},
    {"ColmapBinary",
     [] {
         Bytes bytes = {1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0,
                        8, 0, 0, 0, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0};
         return bytes + bytes_of(std::vector<double>{7, 4, 3});
     }},
    {"Matrix", [] { return to_bytes("700 0 320\n0 700 240\n0 0 1\n0.1\n"); }},
    {"Colmap", [] { return to_bytes("1 PINHOLE 640 480 500 502 320 240\n"); }},
    {"Ros",
     [] {
         return to_bytes(
             "width: 640\nheight: 480\nK: [4, 0, 3, 0, 4, 2, 0, 0, 1]\nP: [4, 0, 3, -1, 0, 4, 2, 0, 0, 0, 1, "
             "0]\n");
     }},
    {"RealSense",
     [] { return to_bytes("{\"fx\": 615, \"fy\": 615, \"ppx\": 319, \"ppy\": 239, \"coeffs\": [0, 1]}"); }},
    {"Open3d",
     [] {
         return to_bytes("{\"intrinsic_matrix\": [5, 0, 0, 0, 5, 0, 3, 2, 1], \"width\": 6, \"height\": 4}");
     }},
    {"Keys", [] { return to_bytes("focal_px: 700\nbaseline_m: 0.1\ncx: 3\ncy: 4\ndoffs_px: 0\n"); }},
};

class Mutation : public testing::TestWithParam<Case> {};

bool accepted(const std::function<void()>& reader, const std::string& what) {
    try {
        reader();
        return true;
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input) << what << ": " << error.what();
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << what << ": " << error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << what << " threw something that is no Error: " << error.what();
    }
    return false;
}

void require_stereo_calibration(const std::filesystem::path& path) {
    if (!read_stereo_calibration(path, Rectify::always))
        throw Error(ErrorKind::input, "it does not tell of two cameras");
}

// Returns how many of the readers accept the file.
int readers_accepting(const Folder& folder, const Bytes& bytes, const std::string& what) {
    const auto path = folder.write("damaged", bytes);
    return accepted([&] { read_image(path); }, what) +
           accepted([&] { read_disparity_map(path, {.scale = 1}); }, what) +
           accepted([&] { read_depth_map(path, {.unit = "m"}); }, what) +
           accepted([&] { read_mask(path, {}); }, what) + accepted([&] { read_confidence(path, {}); }, what) +
           accepted([&] { read_calibration_file(path); }, what) +
           accepted([&] { require_stereo_calibration(path); }, what) +
           accepted([&] { describe_raster(path); }, what);
}

TEST_P(Mutation, ReadsOrIsRefused) {
    const Folder folder;
    const Bytes good = GetParam().make();
    const int whole = readers_accepting(folder, good, "the whole file");
    ASSERT_GE(whole, 1);
    testing::internal::CaptureStderr();
    std::mt19937 random(20240229);
    int refused = 0;
    for (int i = 0; i < kMutations; ++i) {
        Bytes bytes = good;
        std::string what;
        if (i % 4 == 3) {
            bytes.resize(random() % bytes.size());
            what = "cut to " + std::to_string(bytes.size());
        } else {
            // Headers matter most: every other change is in the first bytes.
            const std::size_t at =
                random() % (i % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 64));
            bytes[at] = static_cast<std::uint8_t>(random());
            what = "byte " + std::to_string(at) + " = " + std::to_string(bytes[at]);
        }
        refused += readers_accepting(folder, bytes, what) < whole;
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "a library printed";
    EXPECT_GT(refused, kMutations / 10);
}

INSTANTIATE_TEST_SUITE_P(Formats, Mutation, testing::ValuesIn(kCases),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace hexrelief::readers
