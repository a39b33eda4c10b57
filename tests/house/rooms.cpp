#include "tests/house/rooms.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <set>

namespace hexrelief::testing_house {
namespace fs = std::filesystem;
namespace {

bool below(const std::string& path, const std::string& folder) {
    return path.starts_with(folder + "/");
}

// what: a folder, a file, or a folder and the ending of the files below it, as in "mesher/*_step.h".
bool covers(const std::string& what, const std::string& path) {
    const std::size_t star = what.find('*');
    if (star == std::string::npos) return path == what || below(path, what);
    return path.starts_with(what.substr(0, star)) && path.ends_with(what.substr(star + 1));
}

std::string folder_of(const std::string& path) {
    return path.substr(0, path.rfind('/'));
}

std::vector<SourceFile> read_tree(const fs::path& root, const fs::path& top,
                                  const std::function<bool(const fs::path&)>& wanted) {
    std::vector<SourceFile> files;
    if (!fs::is_directory(top)) return files;
    for (auto it = fs::recursive_directory_iterator(top); it != fs::recursive_directory_iterator(); ++it) {
        const std::string name = it->path().filename().string();
        if (it->is_directory() && (name.starts_with(".") || name.starts_with("build") || name == "out" ||
                                   name == "node_modules" || name == "shared")) {
            it.disable_recursion_pending();
            continue;
        }
        if (!it->is_regular_file() || !wanted(it->path())) continue;
        SourceFile file{fs::relative(it->path(), root).generic_string(), {}};
        std::ifstream in(it->path());
        for (std::string line; std::getline(in, line);) file.lines.push_back(line);
        files.push_back(std::move(file));
    }
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return files;
}

std::string between(const std::string& line, char open, char close) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#') return {};
    const std::size_t word = line.find_first_not_of(" \t", hash + 1);
    if (word == std::string::npos || line.compare(word, 7, "include") != 0) return {};
    const std::size_t from = line.find_first_not_of(" \t", word + 7);
    if (from == std::string::npos || line[from] != open) return {};
    const std::size_t to = line.find(close, from + 1);
    return to == std::string::npos ? std::string() : line.substr(from + 1, to - from - 1);
}

}  // namespace

const std::vector<Room>& rooms() {
    static const std::string data = "pipeline/data", base = "pipeline/base", steps = "mesher/*_step.h";
    static const std::vector<Room> all = {
        {"pipeline/data", {}},
        {"pipeline/base", {data}},
        {"pipeline/readers", {data}},
        {"pipeline/readers/cameras", {data, "pipeline/readers"}},
        {"pipeline/readers/depth", {data, "pipeline/readers"}},
        {"pipeline/readers/photographs", {data, "pipeline/readers"}},
        {"pipeline/readers/tiff", {data, "pipeline/readers"}},
        {"pipeline/matching", {data, base}},
        {"pipeline/matching/common", {data, base}},
        {"pipeline/matching/sgm", {data, base, "pipeline/matching/common"}},
        {"pipeline/matching/refine", {data, base, "pipeline/matching/common"}},
        {"pipeline/stages/by_colour", {data, base}},
        {"pipeline/stages/dequantize", {data, base, "mesher/common/column_slope_step.h"}},
        {"pipeline/stages/densify", {data, base}},
        {"pipeline/stages", {data, "pipeline/matching/matcher.h", "pipeline/stages/by_colour", base}},
        {"pipeline/stages/other_views",
         {data, base, "pipeline/stages/surface.h", "pipeline/stages/surface_raster.h"}},
        {"pipeline/checks", {data, base, "pipeline/stages/disparity_range.h"}},
        {"pipeline/evaluation", {data, base}},
        {"pipeline/alignment/rectify", {data, base}},
        {"pipeline/alignment", {data, base}},
        {"pipeline/files", {data, "exporters/core"}},
        {"pipeline/config", {data, "pipeline/readers", "pipeline/stages", "exporters/core", "mesher/common"}},
        {"pipeline/job/budget", {data, "pipeline/config"}},
        {"pipeline/job/pictures", {data, "exporters/core", "exporters/images", "mesher/mesher.h"}},
        {"pipeline/job",
         {data, "pipeline/readers", "pipeline/alignment/rectify", "pipeline/alignment",
          "pipeline/stages/by_colour", "pipeline/stages/densify", "pipeline/stages/dequantize",
          "pipeline/stages", "pipeline/checks", "pipeline/config", "pipeline/job/budget",
          "pipeline/job/pictures", "pipeline/files", "exporters", "mesher/mesher.h",
          "mesher/common/device_figures.h", "mesher/balance/balance.h", "cuda/cuda_mesher.h",
          "cuda/cuda_matcher.h"}},
        {"pipeline/job/cameras",
         {data, "pipeline/readers", "pipeline/alignment/rectify", "pipeline/stages", "pipeline/checks",
          "pipeline/config", "pipeline/job/log"}},
        {"pipeline/job/log", {data, "pipeline/files/interrupt.h"}},
        {"pipeline/job/maps",
         {data, "pipeline/readers", "pipeline/stages", "pipeline/job/cameras", "exporters/images"}},
        {"pipeline/job/matchers",
         {data, base, "pipeline/readers", "pipeline/stages", "pipeline/config", "pipeline/files",
          "pipeline/job/log", "pipeline/job/maps", "pipeline/matching/matcher.h", "exporters/images"}},
        {"pipeline/job/matchers/network",
         {data, "pipeline/readers", "pipeline/files/sha256.h", "exporters/images"}},
        {"pipeline/job/pairs",
         {data, "pipeline/readers", "pipeline/alignment", "pipeline/stages", "pipeline/checks",
          "pipeline/config"}},
        {"pipeline/readers/windows", {data, "pipeline/readers", "exporters/core/file_transaction.h", base}},
        {"pipeline/cli/gallery",
         {data, "pipeline/readers/image_reader.h", "pipeline/files", "exporters/core", "exporters/viewer"}},
        {"pipeline/job/stamp",
         {"pipeline/config", data, "pipeline/files", "pipeline/job/request.h", "pipeline/job/run_files.h",
          "pipeline/readers/source.h"}},
        {"pipeline/batch",
         {data, "pipeline/readers", "pipeline/config", "pipeline/files", "pipeline/job", "pipeline/job/stamp",
          "exporters/core"}},
        {"pipeline/library",
         {data, "pipeline/readers", "pipeline/config", "pipeline/files", "pipeline/job",
          "pipeline/job/stamp"}},
        {"pipeline/library/python",
         {data, "pipeline/config", "pipeline/evaluation", "pipeline/job", "pipeline/stages"}},
        {"pipeline/cli/arguments", {data, "pipeline/config", "pipeline/library"}},
        {"pipeline/tiles",
         {data, "pipeline/batch/worker.h", "pipeline/config", "pipeline/files", "pipeline/job",
          "pipeline/stages", "pipeline/readers/windows", "exporters", base, "mesher/som/level_plan.h",
          "mesher/tiles"}},
        {"pipeline/tiles/matching",
         {data, "pipeline/checks/pair_statistics.h", "pipeline/config", "pipeline/files", "pipeline/job",
          "pipeline/readers/cameras", "pipeline/stages", "pipeline/readers/windows",
          "mesher/tiles/lattice_tiles.h"}},
        {"pipeline/cli",
         {data, "pipeline/readers", "pipeline/stages", "pipeline/evaluation", "pipeline/config",
          "pipeline/files", "pipeline/job", "pipeline/batch", "pipeline/tiles", "pipeline/library",
          "pipeline/cli/gallery", "exporters", "samples"}},

        {"mesher", {data, base}},
        {"mesher/common", {data, base}},
        {"mesher/som", {data, base, "mesher/common"}},
        {"mesher/balance", {data, base, "mesher/common", "mesher/som"}},
        {"mesher/quality", {data, base, "mesher/common"}},
        {"mesher/surface", {data, base, "mesher/common"}},
        {"mesher/tiles", {data, base, "mesher/common", "mesher/som", "mesher/balance", "mesher/surface"}},
        {"mesher/surface/pixels", {data, base, "mesher/common"}},
        {"mesher/surface/topology", {data, base, "mesher/common", "mesher/surface/pixels"}},
        {"mesher/surface/fit",
         {data, base, "mesher/common", "mesher/surface/pixels", "mesher/surface/topology"}},

        // The mesher's contracts (configuration and result) are what the backend takes and returns; its
        // kernels call the same steps as the mesher's loops.
        {"cuda",
         {data, "mesher/mesher.h", "mesher/common", "mesher/som/level_plan.h", "mesher/balance/balance.h",
          "mesher/surface/cut_disparity_mesh.h", "pipeline/matching/matcher.h", steps}},
        {"cuda/common", {data, base, "mesher/common", steps}},
        {"cuda/som", {data, base, "cuda/common", "mesher/common", "mesher/som/level_plan.h", steps}},
        {"cuda/balance",
         {data, base, "cuda/common", "cuda/som", "mesher/common", "mesher/balance/plan.h", steps}},
        {"cuda/surface",
         {data, base, "cuda/common", "cuda/som", "mesher/common", "mesher/surface/cut_disparity_mesh.h",
          steps}},
        {"cuda/surface/pixels", {data, base, "cuda/common", "mesher/common", steps}},
        {"cuda/surface/topology", {data, base, "cuda/common", "cuda/surface/pixels", "mesher/common", steps}},
        {"cuda/surface/fit",
         {data, base, "cuda/common", "cuda/surface/pixels", "cuda/surface/topology", "mesher/common", steps}},
        {"cuda/matching", {data, base, "cuda/common", "mesher/common", "pipeline/matching"}},
        {"cuda/matching/common", {data, base, "cuda/common", "mesher/common", "pipeline/matching"}},
        {"cuda/matching/sgm",
         {data, base, "cuda/common", "cuda/matching/common", "mesher/common", "pipeline/matching"}},
        {"cuda/matching/refine",
         {data, base, "cuda/common", "cuda/matching/common", "mesher/common", "pipeline/matching"}},

        {"exporters", {data}},
        {"exporters/core", {data}},
        {"exporters/images", {data, base, "exporters/core"}},
        {"exporters/compression", {data, "exporters/core", "exporters/images"}},
        {"exporters/formats",
         {data, "exporters/core", "exporters/images", "exporters/compression",
          "exporters/inspect/describe_formats.h"}},
        {"exporters/inspect", {data, "exporters/core", "exporters/compression"}},

        {"exporters/tileset", {data, "exporters/core/file_transaction.h"}},
        {"exporters/viewer",
         {data, "exporters/core", "exporters/images", "exporters/formats/gltf/gltf_exporter.h",
          "exporters/inspect/describe_formats.h"}},

        {"samples", {data, "exporters"}},
        {"tests", {"pipeline", "mesher", "cuda", "exporters", "samples"}},
    };
    return all;
}

std::vector<SourceFile> source_files(const fs::path& root, const std::string& folder) {
    return read_tree(root, root / folder, [](const fs::path& path) {
        const std::string ending = path.extension().string();
        return ending == ".h" || ending == ".cpp" || ending == ".cu" || ending == ".cuh";
    });
}

std::vector<SourceFile> all_sources() {
    std::vector<SourceFile> files = source_files(HEXRELIEF_SOURCE_DIR, ".");
    for (SourceFile& file : files)
        if (file.path.starts_with("./")) file.path.erase(0, 2);
    return files;
}

std::vector<SourceFile> cmake_files(const fs::path& root) {
    return read_tree(root, root, [](const fs::path& path) {
        return path.filename() == "CMakeLists.txt" || path.extension() == ".cmake";
    });
}

std::vector<SourceFile> other_files(const fs::path& root) {
    return read_tree(root, root, [](const fs::path& path) {
        const std::string ending = path.extension().string();
        return path.filename() == "CMakeLists.txt" || ending == ".cmake" || ending == ".md" ||
               ending == ".sh" || ending == ".py" || ending == ".mjs";
    });
}

std::string quoted_include(const std::string& line) {
    return between(line, '"', '"');
}
std::string angled_include(const std::string& line) {
    return between(line, '<', '>');
}

const Room* room_of(const std::string& path) {
    const Room* innermost = nullptr;
    for (const Room& room : rooms())
        if (below(path, room.folder) && (!innermost || room.folder.size() > innermost->folder.size()))
            innermost = &room;
    return innermost;
}

std::vector<std::string> include_offences(const SourceFile& file) {
    std::vector<std::string> offences;
    const Room* const own = room_of(file.path);
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
        const std::string target = quoted_include(file.lines[i]);
        if (target.empty() || target.find('/') == std::string::npos) continue;  // none, or a sibling
        const std::string where = file.path + ":" + std::to_string(i + 1) + " includes \"" + target + "\"";
        if (room_of(target) == nullptr) {
            offences.push_back(where + ", which is no path from the repository's root");
            continue;
        }
        const bool allowed =
            own != nullptr && (below(target, own->folder) ||
                               std::any_of(own->may_include.begin(), own->may_include.end(),
                                           [&](const std::string& what) { return covers(what, target); }));
        if (!allowed) offences.push_back(where + ", which its folder may not");
    }
    return offences;
}

std::string include_cycle(const std::vector<SourceFile>& files) {
    std::map<std::string, std::set<std::string>> next;
    for (const SourceFile& file : files)
        for (const std::string& line : file.lines)
            if (const std::string target = quoted_include(line); target.find('/') != std::string::npos)
                if (folder_of(target) != folder_of(file.path))
                    next[folder_of(file.path)].insert(folder_of(target));

    std::set<std::string> done;
    std::vector<std::string> way;
    const std::function<std::string(const std::string&)> visit = [&](const std::string& folder) {
        const auto met = std::find(way.begin(), way.end(), folder);
        std::string cycle;
        if (met != way.end()) {
            for (auto step = met; step != way.end(); ++step) cycle += *step + " -> ";
            cycle += folder;
        } else if (!done.contains(folder)) {
            way.push_back(folder);
            for (const std::string& target : next[folder])
                if (cycle = visit(target); !cycle.empty()) break;
            way.pop_back();
            done.insert(folder);
        }
        return cycle;
    };
    for (const auto& [folder, targets] : std::map(next))
        if (const std::string cycle = visit(folder); !cycle.empty()) return cycle;
    return {};
}

}  // namespace hexrelief::testing_house
