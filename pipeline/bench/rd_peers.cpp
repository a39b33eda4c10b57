#include "pipeline/bench/rd_peers.h"

#include <algorithm>
#include <charconv>

#include "pipeline/bench/rd_meshes.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/source.h"

namespace hexrelief::bench::rd {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string_view>;

constexpr std::uintmax_t kMostBytes = std::uintmax_t(1) << 32;

// The error in a line, thrown as text; the caller adds file and line number.
using Wrong = std::string;

float coordinate(std::string_view word) {
    const auto value = readers::codec::parse_number(word);
    if (!value) throw Wrong("a vertex needs three numbers, not " + readers::codec::excerpt(word));
    return static_cast<float>(*value);
}

void add_vertex(const Words& words, SurfaceMesh& mesh) {
    if (words.size() < 4) throw Wrong("a vertex needs three numbers: x, y and disparity in px");
    mesh.image_points.push_back({coordinate(words[1]), coordinate(words[2])});
    mesh.disparities.push_back(coordinate(words[3]));
}

// Parses "7", "7/1", "7//2" or "7/1/2"; negative numbers count from the last vertex so far.
std::uint32_t corner(std::string_view word, std::size_t vertices) {
    long long index = 0;
    const auto end = std::from_chars(word.data(), word.data() + word.size(), index);
    const bool is_number = end.ec == std::errc() && (end.ptr == word.data() + word.size() || *end.ptr == '/');
    const auto count = static_cast<long long>(vertices);
    if (is_number && index < 0) index += count + 1;
    if (!is_number || index < 1 || index > count)
        throw Wrong("a face uses vertex " + readers::codec::excerpt(word) + " of " +
                    std::to_string(vertices));
    return static_cast<std::uint32_t>(index - 1);
}

void add_face(const Words& words, SurfaceMesh& mesh) {
    if (words.size() < 4) throw Wrong("a face needs three corners");
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 1; i < words.size(); ++i)
        corners.push_back(corner(words[i], mesh.disparities.size()));
    for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

}  // namespace

Peer peer_of(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
        throw Error(ErrorKind::usage,
                    "--peer " + text + ": give a name and a folder of .obj files, such as mine=meshes");
    Peer peer{text.substr(0, equals), text.substr(equals + 1)};
    if (!fs::is_directory(peer.folder))
        throw Error(ErrorKind::input, "--peer " + text + ": there is no such folder");
    return peer;
}

std::vector<fs::path> peer_files(const Peer& peer, const std::string& map) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(peer.folder)) {
        const std::string stem = entry.path().stem().string();
        if (entry.path().extension() == ".obj" && (stem == map || stem.starts_with(map + "_")))
            files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

SurfaceMesh read_peer_mesh(const fs::path& path) {
    const readers::codec::SourceFile source = readers::codec::load_file(path, kMostBytes);
    const std::string_view text(reinterpret_cast<const char*>(source.bytes.data()), source.bytes.size());
    SurfaceMesh mesh;
    std::size_t number = 0;
    for (const std::string_view line : readers::codec::lines(text)) {
        ++number;
        const Words words = readers::codec::words(line);
        try {
            if (words.empty()) continue;
            if (words[0] == "v") add_vertex(words, mesh);
            if (words[0] == "f") add_face(words, mesh);
        } catch (const Wrong& wrong) {
            readers::codec::refuse(path, "line " + std::to_string(number) + ": " + wrong);
        }
    }
    if (mesh.triangles.empty()) readers::codec::refuse(path, "it holds no triangle");
    return with_used_vertices(mesh, mesh.triangles);
}

}  // namespace hexrelief::bench::rd
