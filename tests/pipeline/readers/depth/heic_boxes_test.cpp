// Tests what is read from the boxes of HEIC files, on boxes without pictures.
#include "pipeline/readers/depth/heic_boxes.h"

#include <random>

#include "tests/pipeline/readers/depth/sample_boxes.h"

namespace hexrelief::readers::codec {
namespace {

using File = std::vector<std::uint8_t>;

// Two pictures, numbers 1 and 2, and their properties, which ipco lists one after the other.
struct Photograph {
    std::vector<std::uint32_t> group = {1, 2};  // left, right
    std::vector<File> of_first = {}, of_second = {};
    int id_bytes = 2, index_bytes = 1;
    const char* kind = "ster";
};

File ispe(std::uint32_t width, std::uint32_t height) {
    return full_box("ispe", 0, 0, big_endian(width, 4) + big_endian(height, 4));
}

// Numbers are whole 1/1024.
File intrinsics(const char* type, std::uint32_t focal, std::uint32_t center_x, std::uint32_t center_y) {
    const File numbers = big_endian(focal, 4) + big_endian(center_x, 4) + big_endian(center_y, 4);
    if (std::string_view(type) == "cmin") return full_box(type, 0, 10u << 8, numbers);
    return box("uuid", File{0x22, 0xcc, 0x04, 0xc7, 0xd6, 0xd9, 0x4e, 0x07, 0x9d, 0x90, 0x4e, 0xb6, 0xec,
                            0xba, 0xf3, 0xa3} +
                           big_endian(10u << 8, 4) + numbers);
}

File extrinsics(const char* type, std::int32_t micrometres) {
    const File position = big_endian(static_cast<std::uint32_t>(micrometres), 4);
    if (std::string_view(type) == "cmex") return full_box(type, 0, 1, position);
    return box("uuid", File{0x43, 0x63, 0xe9, 0x14, 0x5b, 0x7d, 0x4a, 0xab, 0x97, 0xae, 0xbe, 0xa6, 0x98,
                            0x03, 0xb4, 0x34} +
                           big_endian(1, 4) + position);
}

File entry(std::uint32_t item, std::size_t first, std::size_t count, const Photograph& from) {
    File bytes = big_endian(item, from.id_bytes) + big_endian(count, 1);
    const std::uint32_t essential = from.index_bytes == 2 ? 0x8000 : 0x80;
    for (std::size_t i = first; i < first + count; ++i)
        bytes = bytes + big_endian(i | essential, from.index_bytes);
    return bytes;
}

File file_of(const Photograph& from) {
    File group = big_endian(77, 4) + big_endian(from.group.size(), 4), properties;
    for (const std::uint32_t item : from.group) group = group + big_endian(item, 4);
    for (const auto* list : {&from.of_first, &from.of_second})
        for (const File& property : *list) properties = properties + property;
    const std::size_t first = from.of_first.size(), second = from.of_second.size();
    const File associations =
        full_box("ipma", from.id_bytes == 2 ? 0 : 1, from.index_bytes == 2,
                 big_endian(2, 4) + entry(1, 1, first, from) + entry(2, 1 + first, second, from));
    return box("ftyp", to_bytes("heic")) + full_box("meta", 0, 0,
                                                    box("grpl", full_box(from.kind, 0, 0, group)) +
                                                        box("iprp", box("ipco", properties) + associations));
}

Photograph spatial(const char* intrinsics_type = "cmin", const char* extrinsics_type = "cmex") {
    return {.of_first = {ispe(2000, 1000), intrinsics(intrinsics_type, 768, 512, 256),
                         extrinsics(extrinsics_type, -32000)},
            .of_second = {ispe(2000, 1000), intrinsics(intrinsics_type, 768, 520, 256),
                          extrinsics(extrinsics_type, 32000)}};
}

TEST(HeicPair, TheGroupNamesBothPicturesAndTheirPropertiesTheCamera) {
    std::vector<Photograph> photographs = {spatial(), spatial("uuid", "uuid")};
    photographs.push_back(spatial());
    photographs.back().id_bytes = 4;
    photographs.back().index_bytes = 2;
    for (const Photograph& photograph : photographs) {
        const auto pair = find_heic_pair(file_of(photograph));
        ASSERT_TRUE(pair);
        EXPECT_EQ(pair->left, 1u);
        EXPECT_EQ(pair->right, 2u);
        EXPECT_EQ(pair->width, 2000);
        EXPECT_EQ(pair->height, 1000);
        EXPECT_DOUBLE_EQ(pair->camera.focal_px, 1500);
        EXPECT_DOUBLE_EQ(pair->camera.cx, 1000);
        EXPECT_DOUBLE_EQ(pair->camera.cy, 250);
        EXPECT_DOUBLE_EQ(pair->camera.doffs_px,
                         15.625);  // the right principal point's x minus the left one's
        EXPECT_NEAR(pair->camera.baseline_m, 0.064, 1e-12);
        EXPECT_EQ(pair->camera.width, 2000);
    }
}

TEST(HeicPair, TheOrderOfTheGroupIsLeftThenRight) {
    Photograph photograph = spatial();
    photograph.group = {2, 1};
    const auto pair = find_heic_pair(file_of(photograph));
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->left, 2u);
    EXPECT_DOUBLE_EQ(pair->camera.doffs_px, -15.625);
    EXPECT_NEAR(pair->camera.baseline_m, 0.064, 1e-12);
}

TEST(HeicPair, WhatIsNotSaidIsNotGuessed) {
    Photograph sizes{.of_first = {ispe(2000, 1000)}, .of_second = {ispe(2000, 1000)}};
    ASSERT_TRUE(find_heic_pair(file_of(sizes)));
    EXPECT_EQ(find_heic_pair(file_of(sizes))->camera.focal_px, 0);
    Photograph one_place = spatial();
    one_place.of_second.pop_back();
    EXPECT_EQ(find_heic_pair(file_of(one_place))->camera.baseline_m, 0);
    EXPECT_DOUBLE_EQ(find_heic_pair(file_of(one_place))->camera.focal_px, 1500);
    for (const File& turn : {box("irot", {1}), box("imir", {0}), box("clap", File(32, 0))}) {
        Photograph turned = spatial();
        turned.of_second.push_back(turn);
        EXPECT_EQ(find_heic_pair(file_of(turned))->camera.focal_px, 0);
    }
    Photograph upright = spatial();
    upright.of_second.push_back(box("irot", {0}));
    EXPECT_DOUBLE_EQ(find_heic_pair(file_of(upright))->camera.focal_px, 1500);
    for (const std::uint32_t focal : {0u, 40u, 0xffffffffu, 700u << 10}) {  // of no lens
        Photograph odd = spatial();
        odd.of_first[1] = intrinsics("cmin", focal, 512, 256);
        EXPECT_EQ(find_heic_pair(file_of(odd))->camera.focal_px, 0) << focal;
    }
}

TEST(HeicPair, OtherGroupsAreNoPair) {
    for (const std::vector<std::uint32_t>& group :
         {std::vector<std::uint32_t>{}, {1}, {1, 2, 3}, {0, 2}, {1, 0}}) {
        Photograph odd = spatial();
        odd.group = group;
        EXPECT_FALSE(find_heic_pair(file_of(odd))) << group.size();
    }
    Photograph other = spatial();
    other.kind = "altr";
    EXPECT_FALSE(find_heic_pair(file_of(other)));
    EXPECT_FALSE(find_heic_pair(File{}));
    EXPECT_FALSE(find_heic_pair(box("ftyp", to_bytes("heic"))));
}

File info_entry(std::uint32_t item, const char* type) {
    return full_box("infe", 2, 0, big_endian(item, 2) + big_endian(0, 2) + to_bytes(type) + File(1, 0));
}

File reference(const char* type, std::uint32_t from, std::uint32_t to) {
    return box(type, big_endian(from, 2) + big_endian(1, 2) + big_endian(to, 2));
}

TEST(HeicPictures, AreToldByWhatTheyAreFor) {
    const File urn = to_bytes("urn:mpeg:hevc:2015:auxid:2") + File(1, 0);
    const File properties = ispe(64, 48) + ispe(8, 6) + full_box("auxC", 0, 0, urn);
    const File associations = full_box(
        "ipma", 0, 0, big_endian(4, 4) + File{0, 1, 1, 1, 0, 2, 1, 2, 0, 3, 2, 2, 3} + File{0, 4, 1, 1});
    const auto listed = [&](const File& more) {
        std::string text;
        for (const HeicPicture& picture : list_heic_pictures(
                 full_box("meta", 0, 0, more + box("iprp", box("ipco", properties) + associations))))
            text += std::to_string(picture.width) + " " + picture.role + "; ";
        return text;
    };
    const File items =
        full_box("iinf", 0, 0,
                 big_endian(6, 2) + info_entry(1, "grid") + info_entry(2, "hvc1") + info_entry(3, "hvc1") +
                     info_entry(4, "hvc1") + info_entry(5, "Exif") + info_entry(6, "hvc1"));
    const File primary = full_box("pitm", 0, 0, big_endian(1, 2));
    const File references = full_box("iref", 0, 0,
                                     reference("thmb", 2, 1) + reference("auxl", 3, 1) +
                                         reference("dimg", 1, 6) + reference("cdsc", 5, 1));
    EXPECT_EQ(listed(primary + items + references),
              "64 the picture; 8 thumbnail; 8 depths; 64 another picture; ");
    const File pair = box(
        "grpl",
        full_box("ster", 0, 0, big_endian(9, 4) + big_endian(2, 4) + big_endian(4, 4) + big_endian(1, 4)));
    EXPECT_EQ(listed(primary + items + references + pair),
              "64 right view; 8 thumbnail; 8 depths; 64 left view; ");
    EXPECT_EQ(listed(items),
              "64 another picture; 8 another picture; 8 another picture; 64 another picture; "
              "0 another picture; ");
    EXPECT_EQ(listed({}), "");
}

constexpr std::uint32_t kOffset = 400;

struct Location {
    int version = 0;
    std::uint32_t sizes = 0x4400, method = 0, offset = kOffset, length = 18;
    std::uint32_t extents = 1;
};

// Item 5 holds EXIF data of 14 bytes behind a gap of 3.
File file_with_exif(const Location& at, const char* type = "Exif") {
    const File info =
        full_box("infe", 2, 0, big_endian(5, 2) + big_endian(0, 2) + to_bytes(type) + File(1, 0));
    File place = big_endian(at.sizes, 2) + big_endian(1, at.version < 2 ? 2 : 4) +
                 big_endian(5, at.version < 2 ? 2 : 4);
    if (at.version > 0) place = place + big_endian(at.method, 2);
    place = place + big_endian(0, 2) + big_endian(at.extents, 2);
    if (at.sizes == 0x4400) place = place + big_endian(at.offset, 4) + big_endian(at.length, 4);
    File file =
        full_box("meta", 0, 0,
                 full_box("iinf", 0, 0, big_endian(1, 2) + info) + full_box("iloc", at.version, 0, place));
    file.resize(kOffset, 0);
    return file + big_endian(3, 4) + File(3, 0xee) + to_bytes(std::string_view("MM\0*withcontent", 15));
}

TEST(HeicExif, IsFoundBehindItsOffset) {
    const File whole = {'M', 'M', 0, '*', 'w', 'i', 't', 'h', 'c', 'o', 'n'};
    for (const int version : {0, 1, 2})
        EXPECT_EQ(heic_exif(file_with_exif({.version = version})), whole) << version;
    EXPECT_EQ(heic_exif(file_with_exif({.length = 0xffffffff})).size(), 15u) << "ends with the file";
}

TEST(HeicExif, DamagedOnesAreNone) {
    EXPECT_TRUE(heic_exif(file_with_exif({}, "mime")).empty());
    EXPECT_TRUE(heic_exif(file_with_exif({.offset = 0xfffffff0})).empty());
    EXPECT_TRUE(heic_exif(file_with_exif({.length = 3})).empty());
    EXPECT_TRUE(heic_exif(file_with_exif({.length = 7})).empty()) << "nothing is behind the gap";
    EXPECT_TRUE(heic_exif(file_with_exif({.version = 1, .method = 1})).empty()) << "not in the file";
    EXPECT_TRUE(heic_exif(File{}).empty());
}

// An entry without a size describes nothing, however many extents it claims.
TEST(HeicExif, ExtentsWithoutASizeAreNotCounted) {
    File entries = big_endian(0, 2) + big_endian(0xffff, 2);
    const File nothing = big_endian(5, 2) + big_endian(0, 2) + big_endian(0xffff, 2);
    for (int i = 0; i < 0xffff; ++i) entries.insert(entries.end(), nothing.begin(), nothing.end());
    const File info = full_box("infe", 2, 0, big_endian(5, 2) + big_endian(0, 2) + to_bytes("Exif"));
    EXPECT_TRUE(
        heic_exif(full_box("meta", 0, 0,
                           full_box("iinf", 0, 0, big_endian(1, 2) + info) + full_box("iloc", 0, 0, entries)))
            .empty());
}

// Boxes of length 0, beyond the end, of 64 bits, inside themselves: nothing but an end is asked for.
TEST(HeicBoxes, DamagedFilesEnd) {
    std::mt19937 random(20240229);
    for (const File& good : {file_of(spatial()), file_of(spatial("uuid", "uuid")), file_with_exif({})})
        for (int i = 0; i < 4000; ++i) {
            File bytes = good;
            for (unsigned change = random() % 4 + 1; change > 0; --change) {
                const std::uint8_t values[] = {0, 1, 0x7f, 0xff, static_cast<std::uint8_t>(random())};
                bytes[random() % bytes.size()] = values[random() % 5];
            }
            if (i % 4 == 3) bytes.resize(random() % bytes.size());
            if (const auto pair = find_heic_pair(bytes)) {
                EXPECT_TRUE(pair->camera.focal_px >= 0 && pair->camera.baseline_m >= 0);
            }
            EXPECT_LE(heic_exif(bytes).size(), bytes.size());
            EXPECT_LE(list_heic_pictures(bytes).size(), 32u);
        }
}

}  // namespace
}  // namespace hexrelief::readers::codec
