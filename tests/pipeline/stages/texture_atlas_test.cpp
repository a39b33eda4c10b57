// The atlas of a left picture and the used parts of other views' pictures.
#include "pipeline/stages/other_views/texture_atlas.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hexrelief::stages {
namespace {

TEST(TextureAtlas, EachViewFindsItsPixels) {
    Image left{48, 20, 3, std::vector<std::uint8_t>(48 * 20 * 3, 10)},
        right{96, 40, 1, std::vector<std::uint8_t>(96 * 40, 77)};
    *right.at(81, 31) = 200;
    SurfaceMesh sheet;
    sheet.texcoords = {{80.f / 96, 30.f / 40}, {84.f / 96, 30.f / 40}, {80.f / 96, 34.f / 40}};
    sheet.triangles = {{0, 1, 2}};
    const UsedPart used = used_part(right, sheet, false, 1);
    EXPECT_EQ(std::ranges::count(used.pixels, 1), 4 + 3 + 2 + 1);
    const TextureAtlas atlas = make_atlas(left, {{right, used}}, 2);
    std::vector<Vec2f> texcoords = {{0.5f, 0.5f}, {81.5f / 96, 31.5f / 40}};
    atlas.move_in(std::span(texcoords).first(1), 0);
    atlas.move_in(std::span(texcoords).last(1), 1);
    const auto at = [&](const Vec2f& t) {
        return *atlas.picture.at(static_cast<int>(t.x * atlas.picture.width),
                                 static_cast<int>(t.y * atlas.picture.height));
    };
    EXPECT_EQ(at(texcoords[0]), 10);
    EXPECT_EQ(at(texcoords[1]), 200);
    EXPECT_EQ(atlas.picture.channels, 3);
    EXPECT_LE(atlas.picture.height, 32 + 32);  // of the right picture only the part in use
}

// Returns the place of the atlas in px where it has what is at (x, y) of the first other view's picture.
Vec2f in_atlas(const TextureAtlas& atlas, const Image& picture, float x, float y) {
    Vec2f t = {x / picture.width, y / picture.height};
    atlas.move_in({&t, 1}, 1);
    return {t.x * atlas.picture.width, t.y * atlas.picture.height};
}

TEST(TextureAtlas, PartsLieBesideEachOtherWhole) {
    const Image left{64, 64, 1, std::vector<std::uint8_t>(64 * 64)};
    Image right = left;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) *right.at(x, y) = static_cast<std::uint8_t>(2 * x + 64 * (y / 32));
    SurfaceMesh sheet;  // a small triangle at the top, a wide one at the bottom
    for (const Vec2f& p : {Vec2f{2, 2}, {8, 2}, {2, 8}, {4, 50}, {60, 50}, {4, 60}})
        sheet.texcoords.push_back({p.x / 64, p.y / 64});
    sheet.triangles = {{0, 1, 2}, {3, 4, 5}};
    for (const bool stays_whole : {false, true}) {
        const UsedPart used = used_part(right, sheet, stays_whole, 1);
        const TextureAtlas atlas = make_atlas(left, {{right, used}}, 2);
        EXPECT_EQ(atlas.picture.height, stays_whole ? 64 + 64 : 64 + 16 + 16);
        for (const Vec2f& p : {Vec2f{3.5f, 3.5f}, {5.5f, 51.5f}, {50.5f, 50.5f}}) {
            const Vec2f at = in_atlas(atlas, right, p.x, p.y);
            EXPECT_EQ(*atlas.picture.at(static_cast<int>(at.x), static_cast<int>(at.y)),
                      *right.at(static_cast<int>(p.x), static_cast<int>(p.y)));
        }
        const Vec2f first = in_atlas(atlas, right, 5, 51), last = in_atlas(atlas, right, 59, 51);
        EXPECT_FLOAT_EQ(last.x - first.x, 54);
        EXPECT_FLOAT_EQ(last.y - first.y, 0);
    }
}

TEST(TextureAtlas, WhatIsNotUsedIsSmooth) {
    const Image left{48, 20, 1, std::vector<std::uint8_t>(48 * 20, 100)};
    Image right{48, 20, 1, std::vector<std::uint8_t>(48 * 20, 200)};
    UsedPart used{std::vector<char>(48 * 20), {0, 0, 0, 0, 0, 0}};
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 48; ++x) {
            if (x >= 12 && x <= 14) used.pixels[y * 48 + x] = 1;
            if (x < 10 || x > 16) *right.at(x, y) = 0;  // not even beside what is used
        }
    const TextureAtlas atlas = make_atlas(left, {{right, used}}, 2);
    for (int y = 0; y < atlas.picture.height; ++y)
        for (int x = 0; x < 48; ++x) {
            const int level = *atlas.picture.at(x, y);
            EXPECT_TRUE(level == 100 || level == 200) << x << " " << y;
            EXPECT_TRUE(level == 100 || y >= 32) << x << " " << y;  // down to the next whole block
        }
}

}  // namespace
}  // namespace hexrelief::stages
