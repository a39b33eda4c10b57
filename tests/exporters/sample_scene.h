// A small surface, and folders to write it to, for the exporters' tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/exporter.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace hexrelief::exporters {

// Returns a wavy surface of columns x rows vertices, about 2 m in front of the camera, like one
// from the surface stage.
inline SurfaceMesh sample_mesh(int columns, int rows) {
    SurfaceMesh mesh;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const float u = static_cast<float>(column) / (columns - 1),
                        v = static_cast<float>(row) / (rows - 1);
            const float wave = 0.3f * std::sin(7 * u) * std::cos(5 * v);
            const float dx = 0.3f * 7 * std::cos(7 * u) * std::cos(5 * v) / 2;
            const float dy = 0.3f * 5 * std::sin(7 * u) * std::sin(5 * v);
            const float length = std::sqrt(dx * dx + dy * dy + 1);
            mesh.positions.push_back({2 * u - 1, 0.5f - v, -2 + wave});
            mesh.normals.push_back({-dx / length, -dy / length, 1 / length});
            mesh.texcoords.push_back({u, v});
            mesh.image_points.push_back({u * 64, v * 48});
            mesh.disparities.push_back(10);
        }
    }
    for (int row = 0; row + 1 < rows; ++row) {
        for (int column = 0; column + 1 < columns; ++column) {
            const auto a = static_cast<std::uint32_t>(row * columns + column), b = a + 1, c = a + columns,
                       d = c + 1;
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({b, c, d});
        }
    }
    mesh.metric = true;
    return mesh;
}

// Adds a provenance: half of the vertices are seen by both cameras, the others by others in turn.
inline void add_provenance(SurfaceMesh& mesh) {
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        mesh.provenance.push_back(i % 2 == 0 ? Provenance::both : static_cast<Provenance>(1 + i / 2 % 3));
}

// Returns a camera that sees that surface with disparities of 2.8 to 3.8 px.
inline Calibration sample_camera() {
    return {.focal_px = 64, .cx = 32, .cy = 24, .baseline_m = 0.1, .metric = true};
}

// Returns a texture whose red grows to the right and green downwards; its blue is a checkerboard.
inline Image sample_texture(int width, int height, int channels = 3) {
    Image image{width, height, channels, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            image.pixels.push_back(static_cast<std::uint8_t>(255 * x / (width - 1)));
            if (channels == 1) continue;
            image.pixels.push_back(static_cast<std::uint8_t>(255 * y / (height - 1)));
            image.pixels.push_back((x / 8 + y / 8) % 2 ? 200 : 50);
        }
    }
    return image;
}

inline constexpr const char* kGenerator = "hexrelief test";

// All formats but pages, which ask for a viewer and more of a scene.
inline std::vector<const MeshFormat*> formats_of_files() {
    std::vector<const MeshFormat*> formats = mesh_formats();
    std::erase_if(formats, [](const MeshFormat* format) { return format->is_page; });
    return formats;
}

using TemporaryFolder = test::Folder;

inline std::string contents(const std::filesystem::path& path) {
    EXPECT_TRUE(std::filesystem::exists(path)) << path;
    return test::read_text(path);
}

inline void put(const std::filesystem::path& path, const std::string& text) {
    test::write_text(path, text);
}

}  // namespace hexrelief::exporters
