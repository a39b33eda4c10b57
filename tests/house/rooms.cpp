#include "tests/house/rooms.h"

#include <algorithm>
#include <fstream>
#include <functional>

namespace hexrelief::testing_house {
namespace fs = std::filesystem;
namespace {

bool below(const std::string& path, const std::string& folder) {
    return path.starts_with(folder + "/");
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
    static const std::vector<Room> all = {
        {"pipeline/data", {}},
        {"pipeline/readers", {"pipeline/data"}},
        {"pipeline/stages", {"pipeline/data"}},
        {"mesher", {"pipeline/data"}},
        // The mesher's contracts (configuration and result) are what the backend takes and returns.
        {"cuda", {"pipeline/data", "mesher"}},
        {"exporters", {"pipeline/data"}},
        {"pipeline", {"mesher", "cuda", "exporters"}},
        {"samples", {"pipeline/data", "exporters"}},
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

std::vector<SourceFile> cmake_files(const fs::path& root) {
    return read_tree(root, root, [](const fs::path& path) {
        return path.filename() == "CMakeLists.txt" || path.extension() == ".cmake";
    });
}

std::string quoted_include(const std::string& line) {
    return between(line, '"', '"');
}
std::string angled_include(const std::string& line) {
    return between(line, '<', '>');
}

const Room* room_of(const std::string& path) {
    for (const Room& room : rooms())
        if (below(path, room.folder)) return &room;
    return nullptr;
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
            own != nullptr &&
            (below(target, own->folder) ||
             std::any_of(own->may_include.begin(), own->may_include.end(),
                         [&](const std::string& f) { return target == f || below(target, f); }));
        if (!allowed) offences.push_back(where + ", which its folder may not");
    }
    return offences;
}

}  // namespace hexrelief::testing_house
