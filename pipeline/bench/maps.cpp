#include "pipeline/bench/maps.h"

#include <algorithm>
#include <optional>

#include "pipeline/config/suggest.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;
using namespace table2;

// Returns the ground truth's file, or nothing if the folder does not hold it.
std::optional<fs::path> file_of(const fs::path& data, const table2::PaperMap& map) {
    for (const char* name : {"disp.png", "disp.pgm"})
        if (const fs::path path = data / map.folder / name; fs::is_regular_file(path)) return path;
    return std::nullopt;
}

}  // namespace

void check_names(const std::vector<std::string>& given, const std::vector<std::string>& known,
                 const char* option) {
    for (const std::string& name : given) {
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        std::string list;
        for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
        const std::string near = config::nearest_name(name, known);
        throw Error(ErrorKind::usage, std::string(option) + ": unknown name '" + name + "'" +
                                          (near.empty() ? "" : " (did you mean '" + near + "'?)") +
                                          "; choose among " + list);
    }
}

bool wanted(const std::vector<std::string>& names, const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<FoundMap> find_maps(const fs::path& data, const std::vector<std::string>& sets,
                                const std::vector<std::string>& names, std::vector<std::string>& missing) {
    std::vector<std::string> known;
    for (const table2::PaperMap& map : table2::kPaperMaps)
        if (wanted(sets, map.set)) known.push_back(map.name);
    check_names(names, known, "--maps");
    if (!fs::is_directory(data))
        throw Error(ErrorKind::input,
                    "--data " + data.string() +
                        ": no such folder; give the one that holds middlebury2001/ and so on");
    std::vector<FoundMap> found;
    for (const table2::PaperMap& map : table2::kPaperMaps) {
        if (!wanted(sets, map.set) || !wanted(names, map.name)) continue;
        if (const auto path = file_of(data, map))
            found.push_back({&map, *path});
        else
            missing.push_back(std::string(map.name) + " (" + map.folder + "/disp.png or .pgm)");
    }
    if (found.empty())
        throw Error(ErrorKind::input, "--data " + data.string() +
                                          ": none of the maps asked for is there; expected for example " +
                                          missing.front());
    return found;
}

DisparityMap load_map(const FoundMap& found) {
    readers::DisparityFileConfig file;
    file.scale = found.map->scale;
    return readers::read_disparity_map(found.path, file);
}

}  // namespace hexrelief::bench
