#include "pipeline/files/unchanged_files.h"

#include <sys/stat.h>

#include "pipeline/data/error.h"

namespace hexrelief::files {

UnchangedFiles::State UnchangedFiles::state_of(const std::filesystem::path& path) {
    struct stat s = {};
    if (stat(path.c_str(), &s) != 0) return {};
    return {static_cast<std::int64_t>(s.st_dev),
            static_cast<std::int64_t>(s.st_ino),
            s.st_size,
            s.st_mtim.tv_sec,
            s.st_mtim.tv_nsec,
            s.st_ctim.tv_sec,
            s.st_ctim.tv_nsec};
}

UnchangedFiles::UnchangedFiles(const std::vector<std::filesystem::path>& paths) {
    for (const std::filesystem::path& path : paths) files_.emplace_back(path, state_of(path));
}

void UnchangedFiles::check() const {
    for (const auto& [path, state] : files_)
        if (state_of(path) != state)
            throw Error(
                ErrorKind::input,
                "'" + path.string() + "' was changed while it was read; run again when it is complete");
}

}  // namespace hexrelief::files
