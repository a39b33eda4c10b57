// Tests NPY, NPZ and EXR, and TIFF's unknown samples, as disparity and depth maps.
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/depth/sample_maps.h"

namespace hexrelief::readers {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<float> values_of(const Bytes& file, const DisparityFileConfig& config = {}) {
    const Folder folder;
    return read_disparity_map(folder.write("map", file), config).values;
}

std::string error_in(const Bytes& file, const DisparityFileConfig& config = {}) {
    const Folder folder;
    return error_of([&] { read_disparity_map(folder.write("map", file), config); });
}

std::string npy_header(const std::string& type, const std::string& shape, bool column_major = false) {
    return "{'descr': '" + type + "', 'fortran_order': " + (column_major ? "True" : "False") +
           ", 'shape': " + shape + ", }";
}

template <typename Sample>
Bytes reversed(std::vector<Sample> samples) {
    Bytes bytes = bytes_of(samples);
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(Sample))
        std::reverse(bytes.begin() + i, bytes.begin() + i + sizeof(Sample));
    return bytes;
}

TEST(Npy, EveryTypeOfNumberIsRead) {
    const std::vector<float> expected = {1, 2, 3, 4, 250, kInf};
    const auto whole = [](auto kind) { return bytes_of(std::vector<decltype(kind)>{1, 2, 3, 4, 250, 0}); };
    const DisparityFileConfig pixels{.scale = 1};
    const auto read = [&](const std::string& type, const Bytes& samples) {
        return values_of(make_npy(type, 3, 2, samples), pixels);
    };
    EXPECT_EQ(read("<f4", whole(float())), expected);
    EXPECT_EQ(read("<f8", whole(double())), expected);
    EXPECT_EQ(read("|u1", whole(std::uint8_t())), expected);
    EXPECT_EQ(read("<u2", whole(std::uint16_t())), expected);
    EXPECT_EQ(read("<i2", whole(std::int16_t())), expected);
    EXPECT_EQ(read("<u4", whole(std::uint32_t())), expected);
    EXPECT_EQ(read("=i4", whole(std::int32_t())), expected);
    EXPECT_EQ(read("<i8", whole(std::int64_t())), expected);
    EXPECT_EQ(read("<u8", whole(std::uint64_t())), expected);
    const std::vector<float> small = {1, 2, 3, 4, 127, kInf};
    EXPECT_EQ(read("|i1", {1, 2, 3, 4, 127, 0}), small);
    EXPECT_EQ(read(">f4", reversed<float>({1, 2, 3, 4, 250, 0})), expected);
    EXPECT_EQ(read(">u2", reversed<std::uint16_t>({1, 2, 3, 4, 250, 0})), expected);
    // Halves: 1, 2, 1.5, a third, the least value above 0, infinity.
    EXPECT_EQ(read("<f2", bytes_of(std::vector<std::uint16_t>{0x3c00, 0x4000, 0x3e00, 0x3555, 1, 0x7c00})),
              (std::vector<float>{1, 2, 1.5f, 0.333251953125f, 0x1p-24f, kInf}));
}

TEST(Npy, ShapesOfOneMapAndBothOrders) {
    const Bytes samples = bytes_of(std::vector<float>{1, 2, 3, 4, 5, 6});
    const std::vector<float> rows = {1, 2, 3, 4, 5, 6};
    for (const char* shape : {"(2, 3)", "(1, 2, 3)", "(2,3,1)", "(1, 1, 2, 3)"})
        EXPECT_EQ(values_of(make_npy(npy_header("<f4", shape), samples)), rows) << shape;
    EXPECT_EQ(values_of(make_npy(npy_header("<f4", "(1, 6)"), samples)), rows);
    EXPECT_EQ(values_of(make_npy(npy_header("<f4", "(2, 3)", true), samples)),
              (std::vector<float>{1, 3, 5, 2, 4, 6}));
    EXPECT_EQ(values_of(make_npy(npy_header("<f4", "(2, 3)") + "   \n", samples, 2)), rows) << "version 2";
    EXPECT_EQ(values_of(make_npy("{\"shape\":(2,3,),\"fortran_order\":False,\"descr\":\"<f4\"}", samples)),
              rows);
}

TEST(Npy, IntegersOfAnySignAndSizeAreRead) {
    const DisparityFileConfig moved{.scale = 1, .offset_px = 50};
    const auto bytes = [](auto kind) { return bytes_of(std::vector<decltype(kind)>{-41, 30, 0, -7}); };
    const std::vector<float> expected = {9, 80, 50, 43};
    EXPECT_EQ(values_of(make_npy("|i1", 4, 1, bytes(std::int8_t())), moved), expected);
    EXPECT_EQ(values_of(make_npy("<i2", 4, 1, bytes(std::int16_t())), moved), expected);
    EXPECT_EQ(values_of(make_npy("<i4", 4, 1, bytes(std::int32_t())), moved), expected);
    EXPECT_EQ(values_of(make_npy("<i8", 4, 1, bytes(std::int64_t())), moved), expected);
    const Bytes wide = make_npy("<u4", 3, 1, bytes_of(std::vector<std::uint32_t>{70000, 0, 0xffffffff}));
    EXPECT_EQ(values_of(wide, {.scale = 100}), (std::vector<float>{700, kInf, kInf}));
    const Folder folder;
    const DepthFile depth = read_depth_map(folder.write("d.npy", wide), {});
    EXPECT_EQ(depth.map.values, (std::vector<float>{70, kInf, kInf})) << "mm; the largest number is none";
    EXPECT_EQ(depth.believed, "32-bit integers, mm");
    EXPECT_CONTAINS(error_in(make_npy("<i4", 4, 1, bytes(std::int32_t()))),
                    "signed 32-bit integers does not say");
}

TEST(Npy, OneOfSeveralMapsIsNamedByItsNumber) {
    const Bytes samples = bytes_of(std::vector<float>{1, 2, 3, 4, 5, 6});
    const Bytes planes = make_npy(npy_header("<f4", "(3, 1, 1, 2)"), samples);
    EXPECT_EQ(values_of(make_npy(npy_header("<f4", "(3, 2, 1)"), samples)),
              (std::vector<float>{1, 2, 3, 4, 5, 6}));
    const Bytes maps = make_npy(npy_header("<f4", "(2, 3, 5)"), bytes_of([] {
                                    std::vector<float> all(30);
                                    for (int i = 0; i < 30; ++i)
                                        all[static_cast<std::size_t>(i)] = static_cast<float>(i + 1);
                                    return all;
                                }()));
    EXPECT_EQ(values_of(maps, {.key = "[1]"}).front(), 16);
    const Bytes archive = make_zip({{"depths.npy", maps}, {"K.npy", planes}}, true);
    EXPECT_EQ(values_of(archive, {.key = "depths[0]"}).back(), 15);
    EXPECT_CONTAINS(error_in(archive), "--key depths[0]");
    EXPECT_CONTAINS(error_in(archive, {.key = "depths[2]"}), "name one of its 2");
    // Channels of pixels: 7 x 2 pixels of three.
    std::vector<float> pixels(42);
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i % 3 + 1);
    EXPECT_EQ(values_of(make_npy(npy_header("<f4", "(7, 2, 3)"), bytes_of(pixels)), {.key = "[2]"}),
              std::vector<float>(14, 3));
}

TEST(Npy, MalformedFilesAreRefused) {
    const Bytes samples = bytes_of(std::vector<float>{1, 2, 3, 4, 5, 6});
    const auto error = [&](const std::string& header) { return error_in(make_npy(header, samples)); };
    for (const char* header :
         {"", "{", "{}", "[1]", "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), ",
          "{'descr': '<f4', 'fortran_order': Maybe, 'shape': (2, 3), }",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (2, x), }",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), 'more': 1}",
          "{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), } x",
          "{'descr': 'f', 'shape': (2, 3), }"})
        EXPECT_CONTAINS(error(header), "malformed NPY header") << header;
    EXPECT_CONTAINS(error(npy_header("<c8", "(2, 3)")), "of type '<c8'");
    EXPECT_CONTAINS(error(npy_header("<f3", "(2, 3)")), "of type '<f3'");
    EXPECT_CONTAINS(error(npy_header("|O", "(2, 3)")), "it holds Python's objects");
    EXPECT_CONTAINS(error("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (6,), }"),
                    "structured");
    EXPECT_CONTAINS(error(npy_header("<f4", "(6,)")), "its shape is (6)");
    EXPECT_CONTAINS(error(npy_header("<f4", "(3, 2, 5)")), "its shape is (3, 2, 5)");
    EXPECT_CONTAINS(error(npy_header("<f4", "(3, 2, 5)")), "name one of its 3 by a number in brackets");
    EXPECT_CONTAINS(error(npy_header("<f4", "(9, 2, 3)", true)), "save one of them alone");
    EXPECT_CONTAINS(error(npy_header("<f4", "(2, 2, 2, 2)")), "its shape is (2, 2, 2, 2)");
    EXPECT_CONTAINS(error_in(make_npy(npy_header("<f4", "(99999999, 1, 99999999)"), samples), {.key = "[2]"}),
                    "more than the limit");
    EXPECT_CONTAINS(error_in(make_npy(npy_header("<f4", "(17592186044416, 512, 512)"), {}), {.key = "[0]"}),
                    "truncated: the header promises 17592186044416 times 1048576 bytes")
        << "2^64 bytes";
    EXPECT_CONTAINS(error(npy_header("<f4", "(0, 3)")), "both sides must be at least 1");
    EXPECT_CONTAINS(error(npy_header("<f4", "(99999, 99999)")), "more than the limit");
    EXPECT_CONTAINS(error(npy_header("<f4", "(2, 4)")), "truncated");
    EXPECT_CONTAINS(error(npy_header("<f4", "(2, 2)")), "promises 16 bytes");
    EXPECT_CONTAINS(error_in(make_npy(npy_header("<f4", "(2, 3)"), samples, 9)), "version 9");
    EXPECT_CONTAINS(error_in(to_bytes("\x93NUMPY\1")), "malformed NPY header");
    EXPECT_CONTAINS(error_in(make_npy("<f4", 1, 1, bytes_of(std::vector<float>{kInf}))),
                    "no pixel of the map");
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] { read_image(folder.write("a.npy", make_npy("|u1", 1, 1, {1}))); }),
                    "is a map, not an image");
}

Bytes array(const std::vector<float>& samples) {
    return make_npy("<f4", static_cast<int>(samples.size()), 1, bytes_of(samples));
}

TEST(Npz, TheArrayIsTheOnlyOneOrNamed) {
    for (const bool deflated : {false, true}) {
        EXPECT_EQ(values_of(make_zip({{"arr_0.npy", array({3, 4})}}, deflated)), (std::vector<float>{3, 4}));
        const Bytes two = make_zip(
            {{"note.txt", to_bytes("x")}, {"depth.npy", array({3})}, {"conf.npy", array({9})}}, deflated);
        EXPECT_EQ(values_of(two, {.key = "conf"}), (std::vector<float>{9}));
        EXPECT_EQ(values_of(two), (std::vector<float>{3})) << "a usual name";
        EXPECT_CONTAINS(error_in(make_zip({{"a.npy", array({3})}, {"b.npy", array({9})}}, deflated)),
                        "name one by --key: a, b");
        EXPECT_CONTAINS(error_in(two, {.key = "z"}), "no array 'z'; it has depth, conf");
    }
    const Folder folder;
    const auto path = folder.write("a.npz", make_zip({{"d.npy", array({2})}, {"e.npy", array({3})}}, true));
    EXPECT_EQ(read_depth_map(path, {.key = "e"}).map.values, (std::vector<float>{3}));
    EXPECT_EQ(describe_raster(path, "e")->format, "npz");
    EXPECT_TRUE(describe_raster(path, "e")->is_float);
}

TEST(Npz, TheMapIsFoundByNameOrByShape) {
    const Bytes matrix = make_npy("<f8", 3, 3, bytes_of(std::vector<double>(9, 1)));
    const Bytes map = make_npy("<f4", 6, 5, bytes_of(std::vector<float>(30, 2)));
    const Bytes confidence = make_npy("<f4", 6, 5, bytes_of(std::vector<float>(30, 0.5f)));
    const Bytes words = make_npy("{'descr': '<U3', 'fortran_order': False, 'shape': (1,), }", Bytes(12));
    EXPECT_EQ(values_of(make_zip({{"K.npy", matrix}, {"out.npy", map}, {"w.npy", words}}, true)).size(), 30u);
    const Folder folder;
    const auto path = folder.write(
        "a.npz", make_zip({{"conf.npy", confidence}, {"Depth.npy", map}, {"w.npy", words}}, true));
    EXPECT_EQ(read_depth_map(path, {}).map.values[0], 2);
    EXPECT_EQ(read_confidence(path, {.threshold = 0.4}).kept[0], 1);
    EXPECT_CONTAINS(error_of([&] { read_confidence(path, {.threshold = 0.6}); }),
                    "below input.confidence.threshold");
    EXPECT_EQ(list_contents(path),
              (std::vector<std::string>{"conf: 5 x 6 float32", "Depth: 5 x 6 float32", "w: no numbers"}));
}

TEST(Npz, DamagedArchivesAndBombsAreRefused) {
    const Bytes good = make_zip({{"d.npy", array({1, 2, 3})}}, true);
    EXPECT_CONTAINS(error_in(make_zip({}, true)), "without numpy arrays");
    EXPECT_CONTAINS(error_in(make_zip({{"a.txt", {1}}}, false)), "without numpy arrays");
    EXPECT_CONTAINS(error_in(Bytes(good.begin(), good.end() - 5)), "damaged ZIP");
    EXPECT_CONTAINS(error_in(make_zip({{"d.npy", to_bytes("hello there")}}, true)), "malformed NPY header");
    const std::size_t directory = good.size() - 22 - 46 - 5;
    const auto with = [&](std::size_t at, Bytes bytes) {
        Bytes changed = good;
        std::copy(bytes.begin(), bytes.end(), changed.begin() + static_cast<std::ptrdiff_t>(directory + at));
        return changed;
    };
    EXPECT_CONTAINS(error_in(with(24, {0, 0, 0, 0x70})), "damaged ZIP") << "unpacks to 1.9 GB, it says";
    EXPECT_CONTAINS(error_in(with(24, {255, 255, 255, 255})), "4 GiB");
    EXPECT_CONTAINS(error_in(with(16, {1, 2, 3, 4})), "damaged ZIP") << "checksum";
    EXPECT_CONTAINS(error_in(with(10, {9})), "another method");
    EXPECT_CONTAINS(error_in(with(8, {1})), "encrypted");
    EXPECT_CONTAINS(error_in(with(42, {255, 255, 0, 0})), "damaged ZIP");
    // 4 MiB of zeros in 4 KiB; the header says 4 bytes.
    Bytes bomb = array({1});
    bomb.resize(bomb.size() + (4u << 20));
    EXPECT_CONTAINS(error_in(make_zip({{"d.npy", bomb}}, true)), "malformed: the header promises 4 bytes");
}

#ifdef HEXRELIEF_HAS_OPENEXR
TEST(Exr, TheChannelIsTheOnlyOneUsualOrNamed) {
    const std::vector<float> near = {1, 2, 3, 4, 5, 6}, far = {7, 8, 9, 10, 11, 12};
    EXPECT_EQ(values_of(make_exr(3, 2, {{"any", near}})), near);
    EXPECT_EQ(values_of(make_exr(3, 2, {{"B", near}, {"G", near}, {"R", near}})), near) << "grey";
    EXPECT_CONTAINS(error_in(make_exr(3, 2, {{"B", far}, {"G", far}, {"R", near}})), "a map has one channel");
    EXPECT_EQ(values_of(make_exr(3, 2, {{"A", far}, {"R", near}})), near);
    EXPECT_EQ(values_of(make_exr(3, 2, {{"N.X", far}, {"N.Y", far}, {"N.Z", far}, {"Z", near}})), near);
    EXPECT_EQ(values_of(make_exr(3, 2, {{"R", far}, {"depth.B", far}, {"depth.R", near}})), near);
    EXPECT_EQ(
        values_of(make_exr(3, 2, {{"L.Depth.Z", near}, {"L.Mist.Z", far}, {"L.N.X", far}, {"L.N.Z", far}})),
        near);
    // OpenEXR decodes four channels of one type by a special routine.
    for (const char* key : {"A", "B", "G", "R"}) {
        const Bytes four = make_exr(3, 2, {{"A", near}, {"B", near}, {"G", near}, {"R", near}});
        EXPECT_EQ(values_of(four, {.key = key}), near);
    }
    const Bytes several = make_exr(3, 2, {{"A", far}, {"View.Depth.Z", near}, {"Y", far}});
    EXPECT_EQ(values_of(several), near);
    EXPECT_EQ(values_of(several, {.key = "A"}), far);
    EXPECT_CONTAINS(error_in(several, {.key = "Z"}), "no channel 'Z'; it has A, View.Depth.Z, Y");
    EXPECT_CONTAINS(error_in(make_exr(3, 2, {{"a", near}, {"b", near}})), "name one by --key: a, b");
    const Folder folder;
    const auto found = describe_raster(folder.write("a.exr", several));
    EXPECT_EQ(found->format, "exr");
    EXPECT_EQ(found->width, 3);
    EXPECT_EQ(found->channels, 3);
    EXPECT_TRUE(found->is_float);
}

TEST(Exr, AttributesLongerThanTheFileAreRefused) {
    const std::array<int, 4> window{0, 0, 1, 0};
    const std::string name("displayWindow\0box2i", 20);  // with the zeros after both words
    for (const Bytes& good :
         {make_exr(2, 1, {{"Z", {1, 2}}}),
          make_exr_parts({{"a", {{"A", {3, 4}}}, window, window}, {"b", {{"Z", {1, 2}}}, window, window}})}) {
        Bytes bad = good;
        const auto found = std::find_end(bad.begin(), bad.end(), name.begin(), name.end());
        ASSERT_NE(found, bad.end());
        found[23] = 0x60;  // 1.5 GiB
        EXPECT_CONTAINS(error_in(bad), "an attribute is longer than the file");
    }
}

TEST(Exr, ThePartIsTheOneWithTheUsualNameOrNamed) {
    const std::vector<float> near = {1, 2, 3, 4, 5, 6}, far = {7, 8, 9, 10, 11, 12};
    const std::array<int, 4> window{0, 0, 2, 1};
    const Bytes two = make_exr_parts({{"beauty", {{"B", far}, {"G", far}, {"R", far}}, window, window},
                                      {"data", {{"A", far}, {"Z", near}}, window, window}});
    EXPECT_EQ(values_of(two), near);
    EXPECT_EQ(values_of(two, {.key = "beauty.R"}), far);
    EXPECT_EQ(values_of(two, {.key = "data.Z"}), near);
    EXPECT_CONTAINS(error_in(two, {.key = "data.R"}), "beauty.B, beauty.G, beauty.R, data.A, data.Z");
    const Folder folder;
    const auto path = folder.write("two.exr", two);
    EXPECT_EQ(list_contents(path), (std::vector<std::string>{"part beauty: B float, G float, R float",
                                                             "part data: A float, Z float"}));
    for (std::size_t bytes = 0; bytes < two.size(); bytes += 97)
        EXPECT_NE(error_in(Bytes(two.begin(), two.begin() + static_cast<std::ptrdiff_t>(bytes))), "");
}

TEST(Exr, AMapIsTheChannelAloneInItsPartAndAPictureTheColours) {
    const std::vector<float> near = {1, 2, 3, 4, 5, 6}, half(6, 0.5f);
    const std::array<int, 4> window{0, 0, 2, 1};
    const std::vector<ExrChannel> colours = {{"B", half}, {"G", half}, {"R", half}};
    EXPECT_EQ(
        values_of(make_exr_parts({{"D", {{"Y", near}}, window, window}, {"rgb", colours, window, window}})),
        near);
    const Folder folder;
    const auto render = folder.write(
        "render.exr",
        make_exr_parts({{"", {{"B", half}, {"G", half}, {"R", half}, {"Z", near}}, window, window}}));
    EXPECT_EQ(read_image(render).channels, 3);
    EXPECT_EQ(values_of(read_bytes(render)), near);
}

TEST(Exr, TheDisplayWindowIsThePicture) {
    const std::vector<float> four = {1, 2, 3, 4};
    // The data window is the display window's middle; then the display window is the data window's right
    // half.
    const Bytes crop = make_exr_parts({{"", {{"Z", four}}, {1, 1, 2, 2}, {0, 0, 3, 3}}});
    EXPECT_EQ(values_of(crop), (std::vector<float>{kInf, kInf, kInf, kInf, kInf, 1, 2, kInf, kInf, 3, 4, kInf,
                                                   kInf, kInf, kInf, kInf}));
    const Bytes overscan = make_exr_parts({{"", {{"Z", four}}, {-1, 0, 0, 1}, {0, 0, 1, 1}}});
    EXPECT_EQ(values_of(overscan), (std::vector<float>{2, kInf, 4, kInf}));
    EXPECT_CONTAINS(error_in(make_exr_parts({{"", {{"Z", four}}, {4, 4, 5, 5}, {0, 0, 1, 1}}})),
                    "outside of its display window");
    EXPECT_CONTAINS(error_in(make_exr_parts({{"", {{"Z", four}}, {0, 0, 1, 1}, {0, 0, 19999, 19999}}})),
                    "64 times the pixels of its data window")
        << "a display window of 400 megapixels in a small file";
    const Folder folder;
    const auto found = describe_raster(folder.write("crop.exr", crop));
    EXPECT_EQ(found->width, 4);
    EXPECT_CONTAINS(list_contents(folder.path() / "crop.exr")[0], "data window 2 x 2 px at 1,1");
}

TEST(Exr, LossyCompressionIsRead) {
    const std::vector<float> flat(32 * 32, 2.5f);
    const Bytes file = make_exr_parts({{"", {{"Z", flat}}, {0, 0, 31, 31}, {0, 0, 31, 31}, true, true}});
    for (const float value : values_of(file)) ASSERT_NEAR(value, 2.5f, 0.01f);
}

TEST(Exr, PackedAndTiledFilesHoldTheSame) {
    std::vector<float> near(37 * 21), far(near.size());
    for (std::size_t i = 0; i < near.size(); ++i) {
        near[i] = 1 + 0.25f * static_cast<float>(i % 50);
        far[i] = 2 * near[i];
    }
    for (const bool zip : {false, true})
        for (const int tile : {0, 8, 64}) {
            if (tile == 0 && !zip) continue;
            const Bytes file = make_exr(37, 21, {{"A", far}, {"Z", near}}, {.zip = zip, .tile = tile});
            EXPECT_EQ(values_of(file), near) << zip << " " << tile;
            EXPECT_EQ(values_of(file, {.key = "A"}), far) << zip << " " << tile;
            const Bytes cut(file.begin(), file.end() - static_cast<std::ptrdiff_t>(file.size() / 4));
            EXPECT_CONTAINS(error_in(cut), "malformed or truncated EXR");
        }
}

TEST(Exr, MalformedFilesAreRefused) {
    const Bytes good = make_exr(3, 2, {{"Z", {1, 2, 3, 4, 5, 6}}});
    EXPECT_CONTAINS(error_in(Bytes(good.begin(), good.end() - 3)), "malformed or truncated EXR");
    EXPECT_CONTAINS(error_in(Bytes(good.begin(), good.begin() + 60)), "malformed or truncated EXR");
    // A data window of 40000 x 40000.
    Bytes huge = good;
    const Bytes wanted = to_bytes("box2i");
    const auto name = std::search(huge.begin(), huge.end(), wanted.begin(), wanted.end());
    const Bytes far = {0x40, 0x9c, 0, 0, 0x40, 0x9c, 0, 0};
    std::copy(far.begin(), far.end(), name + 6 + 4 + 8);
    EXPECT_NE(error_in(huge), "");
}
#endif

TEST(TiffNodata, IsUnknown) {
    const Bytes floats = bytes_of(std::vector<float>{1, -9999, 250, 4});
    EXPECT_EQ(values_of(make_tiff(2, 2, floats, {.bits = 32, .format = 3, .nodata = "250"})),
              (std::vector<float>{1, kInf, kInf, 4}));
    EXPECT_EQ(values_of(make_tiff(2, 2, floats, {.bits = 32, .format = 3, .nodata = "nan"})),
              (std::vector<float>{1, kInf, 250, 4}));
    EXPECT_EQ(values_of(make_tiff(2, 1, bytes_of(std::vector<std::uint16_t>{256, 777}),
                                  {.bits = 16, .nodata = "777"})),
              (std::vector<float>{1, kInf}));
    const Folder folder;
    EXPECT_EQ(
        read_depth_map(
            folder.write("z.tif", make_tiff(2, 2, floats, {.bits = 32, .format = 3, .nodata = "250 "})), {})
            .map.values,
        (std::vector<float>{1, kInf, kInf, 4}));
}

}  // namespace
}  // namespace hexrelief::readers
