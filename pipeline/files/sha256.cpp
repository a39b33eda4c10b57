#include "pipeline/files/sha256.h"

#include <nettle/sha2.h>
#include <sys/stat.h>

#include <fstream>

#include "pipeline/data/error.h"

namespace hexrelief::files {
namespace {

std::string digits_of(sha256_ctx& context) {
    std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest{};
    sha256_digest(&context, digest.size(), digest.data());
    std::string text;
    for (const std::uint8_t byte : digest) {
        text += "0123456789abcdef"[byte >> 4];
        text += "0123456789abcdef"[byte & 15];
    }
    return text;
}

}  // namespace

std::string sha256_of(const void* data, std::size_t bytes) {
    sha256_ctx context;
    sha256_init(&context);
    sha256_update(&context, bytes, static_cast<const std::uint8_t*>(data));
    return digits_of(context);
}

std::string sha256_of_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(ErrorKind::input, "cannot read " + path.string() + " to hash it");
    sha256_ctx context;
    sha256_init(&context);
    std::vector<char> buffer(1 << 16);
    do {
        file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
        sha256_update(&context, static_cast<std::size_t>(file.gcount()),
                      reinterpret_cast<const std::uint8_t*>(buffer.data()));
    } while (file);
    if (file.bad()) throw Error(ErrorKind::input, "cannot read " + path.string() + " to its end");
    return digits_of(context);
}

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
