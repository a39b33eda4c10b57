#include "pipeline/files/output_set.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <vector>

#include "exporters/core/file_transaction.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

// Held while files are written, so that an interrupt sees either all of a file set's names here or none.
std::mutex outputs_mutex;
std::vector<fs::path>
    fresh_paths;  // files and folders made by this run, in the order in which they were made

[[noreturn]] void fail(const fs::path& path, const std::string& why) {
    throw Error(ErrorKind::output, "cannot write " + path.string() + ": " + why);
}

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

void remove_fresh_paths() {
    std::error_code ignored;
    for (auto path = fresh_paths.rbegin(); path != fresh_paths.rend(); ++path) fs::remove(*path, ignored);
    fresh_paths.clear();
}

void copy_to_standard_output(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::vector<char> part(1 << 20);
    bool taken = file.good();
    while (taken && file.read(part.data(), static_cast<std::streamsize>(part.size())).gcount() > 0) {
        const auto bytes = static_cast<std::size_t>(file.gcount());
        taken = std::fwrite(part.data(), 1, bytes, stdout) == bytes;
    }
    if (!taken || std::fflush(stdout) != 0) fail("-", std::strerror(errno));
}

}  // namespace

bool is_standard_output(const fs::path& path) {
    return path.stem() == "-" && !path.has_parent_path();
}

void check_writable_file(const fs::path& path) {
    std::error_code code;
    const fs::path folder = folder_of(path);
    if (path.filename().empty() || fs::is_directory(path, code))
        fail(path, "it is a folder; give a file name");
    check_writable_folder(folder);
    if (fs::exists(path, code) && access(path.c_str(), W_OK) != 0) fail(path, std::strerror(errno));
}

void check_writable_folder(const fs::path& folder) {
    std::error_code code;
    fs::path existing = folder;
    while (!fs::exists(existing, code) && existing.has_relative_path()) existing = folder_of(existing);
    if (!fs::is_directory(existing, code)) fail(folder, existing.string() + " is not a folder");
    if (access(existing.c_str(), W_OK) != 0)
        fail(folder, "the folder " + existing.string() + ": " + std::strerror(errno));
}

bool FileIdentity::operator==(const FileIdentity& other) const {
    return path == other.path || (node != 0 && node == other.node && device == other.device);
}

FileIdentity identify(const fs::path& path) {
    std::error_code code;
    fs::path target = fs::absolute(path, code);
    // A link whose target is still missing: that one will be made.
    for (int links = 0; links < 40 && fs::is_symlink(target, code) && !fs::exists(target, code); ++links)
        target = target.parent_path() / fs::read_symlink(target, code);
    FileIdentity identity{fs::weakly_canonical(target, code), 0, 0};
    struct stat status {};
    if (stat(target.c_str(), &status) == 0) {
        identity.device = status.st_dev;
        identity.node = status.st_ino;
    }
    return identity;
}

OutputSet::~OutputSet() {
    const std::lock_guard lock(outputs_mutex);
    remove_fresh_paths();
}

void OutputSet::make_folder(const fs::path& folder) {
    wait_if_interrupted();
    const std::lock_guard lock(outputs_mutex);
    std::error_code code;
    std::vector<fs::path> missing;
    for (fs::path at = folder; !at.empty() && !fs::exists(at, code); at = at.parent_path())
        missing.push_back(at);
    for (auto at = missing.rbegin(); at != missing.rend(); ++at) {
        if (fs::create_directory(*at, code)) fresh_paths.push_back(*at);
        if (code) fail(*at, code.message());
    }
}

fs::path OutputSet::place(const fs::path& path) {
    if (!is_standard_output(path)) {
        make_folder(folder_of(path));
        return path;
    }
    wait_if_interrupted();
    const std::lock_guard lock(outputs_mutex);
    std::string folder = (fs::temp_directory_path() / "hexrelief-XXXXXX").string();
    if (!mkdtemp(folder.data())) fail(folder, std::strerror(errno));
    fresh_paths.emplace_back(folder);
    for_standard_output_ = fs::path(folder) / ("output" + path.extension().string());
    return for_standard_output_;
}

std::vector<fs::path> OutputSet::add(const std::vector<fs::path>& planned,
                                     const std::function<std::vector<fs::path>()>& write) {
    wait_if_interrupted();
    const std::lock_guard lock(outputs_mutex);
    std::error_code code;
    std::vector<fs::path> existing;
    for (const fs::path& path : planned)
        if (fs::exists(path, code)) existing.push_back(path);
    std::vector<fs::path> written = write();
    for (const fs::path& path : written)
        if (std::find(existing.begin(), existing.end(), path) == existing.end()) fresh_paths.push_back(path);
    return written;
}

void OutputSet::commit() {
    const std::lock_guard lock(outputs_mutex);
    if (!for_standard_output_.empty()) {
        copy_to_standard_output(for_standard_output_);
        std::error_code ignored;
        fs::remove_all(for_standard_output_.parent_path(), ignored);
    }
    fresh_paths.clear();
}

void roll_back_outputs() {
    remove_pending_files();  // first: a write under way fails at its next step and lets go of the mutex
    const std::lock_guard lock(outputs_mutex);
    remove_fresh_paths();
}

}  // namespace hexrelief
