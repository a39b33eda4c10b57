#include <meshoptimizer.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "exporters/inspect/describe_mesh.h"
#include "tests/exporters/draco_decode.h"
#include "tests/exporters/sample_scene.h"
#include "tests/exporters/tileset/tile_scenes.h"

namespace hexrelief::tileset {
namespace {

using Place = std::array<double, 3>;
using Bytes = std::vector<std::uint8_t>;

// The positions of a GLB as its node places them, in double precision.
class GlbPositions {
  public:
    explicit GlbPositions(const std::filesystem::path& path) {
        const std::string file = exporters::contents(path);
        std::uint32_t size = 0;
        std::memcpy(&size, file.data() + 12, sizeof size);
        json_ = nlohmann::json::parse(file.substr(20, size));
        data_.assign(file.begin() + 20 + size + 8, file.end());
    }

    std::vector<Place> read() const {
        const auto& primitive = json_["meshes"][0]["primitives"][0];
        const auto& accessor = json_["accessors"][primitive["attributes"]["POSITION"].get<int>()];
        std::vector<Place> places;
        if (primitive.contains("extensions")) {
            const auto& draco = primitive["extensions"]["KHR_draco_mesh_compression"];
            const auto decoded =
                exporters::decode_draco(bytes_of(json_["bufferViews"][draco["bufferView"].get<int>()]));
            for (const Vec3f& p : decoded.positions) places.push_back({p.x, p.y, p.z});
        } else {
            places = stored(accessor);
        }
        check_bounds(accessor, places);
        const auto& node = json_["nodes"][0];
        const Place scale = node.value("scale", Place{1, 1, 1}), shift = node.value("translation", Place{});
        for (Place& p : places)
            for (std::size_t k = 0; k < 3; ++k) p[k] = shift[k] + scale[k] * p[k];
        return places;
    }

  private:
    Bytes bytes_of(const nlohmann::json& view) const {
        const auto first = data_.begin() + view.value("byteOffset", 0);
        return {first, first + view["byteLength"].get<int>()};
    }
    std::vector<Place> stored(const nlohmann::json& accessor) const {
        const auto& view = json_["bufferViews"][accessor["bufferView"].get<int>()];
        const bool is_float = accessor["componentType"] == 5126;
        const auto count = accessor["count"].get<std::size_t>();
        std::size_t stride = view.value("byteStride", 12);
        Bytes bytes;
        if (view.contains("extensions")) {
            const auto& coded = view["extensions"]["EXT_meshopt_compression"];
            stride = coded["byteStride"];
            bytes.resize(count * stride);
            const Bytes packed = bytes_of(coded);
            EXPECT_EQ(meshopt_decodeVertexBuffer(bytes.data(), count, stride, packed.data(), packed.size()),
                      0);
        } else {
            bytes = bytes_of(view);
        }
        EXPECT_TRUE(is_float || accessor["componentType"] == 5123);
        std::vector<Place> places(count);
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint8_t* const at = bytes.data() + accessor.value("byteOffset", 0) + i * stride;
                float value = 0;
                std::uint16_t cell = 0;
                if (is_float)
                    std::memcpy(&value, at + 4 * k, sizeof value);
                else
                    std::memcpy(&cell, at + 2 * k, sizeof cell);
                places[i][k] = is_float ? value : cell;
            }
        return places;
    }
    static void check_bounds(const nlohmann::json& accessor, const std::vector<Place>& places) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto less = [&](const Place& a, const Place& b) { return a[k] < b[k]; };
            const auto [low, high] = std::minmax_element(places.begin(), places.end(), less);
            EXPECT_EQ(accessor["min"][k].get<double>(), (*low)[k]);
            EXPECT_EQ(accessor["max"][k].get<double>(), (*high)[k]);
        }
    }

    nlohmann::json json_;
    Bytes data_;
};

struct GridCase {
    const char* name;
    exporters::Compression compression;
    double step_m;
    Cell far;
    int columns;  // of one tile, 640 steps each
};

std::ostream& operator<<(std::ostream& out, const GridCase& test) {
    return out << test.name;
}

class ExactGrid : public ::testing::TestWithParam<GridCase> {};

TEST_P(ExactGrid, EveryPositionIsItsCell) {
    const auto& [name, compression, step_m, far, columns] = GetParam();
    exporters::TemporaryFolder folder;
    const Image texture = exporters::sample_texture(16, 16);
    exporters::ExportConfig config{.compression = compression};
    std::array<std::set<Place>, 2> found;
    for (int side = 0; side < 2; ++side) {
        const GridTile tile = grid_tile({side * columns, 0}, {(side + 1) * columns, 4}, 1, step_m, far);
        exporters::Scene scene{&tile.mesh, &texture, exporters::kGenerator, ""};
        scene.grid_step_m = step_m;
        scene.origin_m = tile.origin_m;
        const std::filesystem::path path = folder / (std::to_string(side) + ".glb");
        exporters::export_scene(scene, config, path);
        const std::vector<Place> places = GlbPositions(path).read();
        found[side].insert(places.begin(), places.end());
        std::set<Place> given;
        for (const Vec3f& p : tile.mesh.positions)
            given.insert({tile.origin_m[0] + p.x, tile.origin_m[1] + p.y, tile.origin_m[2] + p.z});
        EXPECT_EQ(found[side], given);
        const inspect::MeshDescription description = exporters::describe_mesh(path);
        EXPECT_EQ(description.vertices, static_cast<long long>(tile.mesh.positions.size()));
        EXPECT_EQ(description.min.x, static_cast<float>(tile.low_m[0]));
        EXPECT_EQ(description.max.z, static_cast<float>(tile.high_m[2]));
    }
    std::vector<Place> shared;
    std::set_intersection(found[0].begin(), found[0].end(), found[1].begin(), found[1].end(),
                          std::back_inserter(shared));
    EXPECT_EQ(shared.size(), 5u);
}

std::vector<GridCase> grid_cases() {
    const Cell far = {10'240'000'000, -10'239'999'123, 3'000'000'001};  // about 1e7 m
    std::vector<GridCase> cases;
    for (const auto& [name, compression] : {std::pair{"none", exporters::Compression::none},
                                            {"quantized", exporters::Compression::quantized},
                                            {"meshopt", exporters::Compression::meshopt},
                                            {"draco", exporters::Compression::draco}}) {
        cases.push_back({name, compression, 0x1p-10, {0, 0, -4'000'000}, 20});
        cases.push_back({name, compression, 0x1p-10, far, 20});
        cases.push_back({name, compression, 0x1p-10, far, 200});                // more than 16 bits
        cases.push_back({name, compression, 0x1p-30, {0, 0, -4'000'000}, 20});  // a microscope's
        cases.push_back({name, compression, 4, far, 20});
    }
    return cases;
}

INSTANTIATE_TEST_SUITE_P(Compressions, ExactGrid, ::testing::ValuesIn(grid_cases()));

// A .drc keeps positions relative to the mesh's own origin, with the same precision.
TEST(ExactGridInDrc, EveryPositionIsItsCell) {
    exporters::TemporaryFolder folder;
    const GridTile tile = grid_tile({0, 0}, {20, 4}, 1, 0x1p-30, {0, 0, -4'000'000});
    exporters::Scene scene{&tile.mesh, nullptr, exporters::kGenerator, ""};
    scene.grid_step_m = 0x1p-30;
    exporters::export_scene(scene, {}, folder / "tile.drc");
    const std::string file = exporters::contents(folder / "tile.drc");
    std::set<Place> found, given;
    for (const Vec3f& p : exporters::decode_draco({file.begin(), file.end()}).positions)
        found.insert({p.x, p.y, p.z});
    for (const Vec3f& p : tile.mesh.positions) given.insert({p.x, p.y, p.z});
    EXPECT_EQ(found, given);
}

}  // namespace
}  // namespace hexrelief::tileset
