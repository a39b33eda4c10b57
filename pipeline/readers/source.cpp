#include "pipeline/readers/source.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::readers::codec {
namespace {

struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, Closer>;

std::string system_reason(int code) {
    return std::generic_category().message(code);
}

// Opens a regular file. The kind is checked first, because on Linux a folder can be opened like a file,
// and a pipe blocks.
FileHandle open_regular(const std::filesystem::path& path) {
    std::error_code failure;
    const auto status = std::filesystem::status(path, failure);
    if (status.type() == std::filesystem::file_type::not_found) refuse(path, "no such file; check the path");
    if (failure) refuse(path, failure.message());
    if (std::filesystem::is_directory(status)) refuse(path, "it is a folder; name a file in it");
    if (!std::filesystem::is_regular_file(status)) refuse(path, "not a regular file; copy it to one first");
    FileHandle file(std::fopen(path.c_str(), "rb"));
    if (!file) refuse(path, system_reason(errno));
    return file;
}

SourceFile read_bytes(const std::filesystem::path& path, std::FILE* file, std::size_t count) {
    SourceFile source{path, std::vector<std::uint8_t>(count)};
    const std::size_t got = count == 0 ? 0 : std::fread(source.bytes.data(), 1, count, file);
    if (got < count && std::ferror(file)) refuse(path, system_reason(errno));
    source.bytes.resize(got);
    return source;
}

// Refuses large files of which hardly anything is on the disk: reading them takes the memory of their size.
// File systems that compress, or do not count blocks, store any picture in more than that, or say 0.
void refuse_hollow(const std::filesystem::path& path, std::FILE* file) {
    constexpr std::int64_t large = 64 << 20, block = 512, least_share = 1000;
    struct stat status = {};
    if (::fstat(::fileno(file), &status) != 0 || status.st_size < large || status.st_blocks == 0) return;
    const std::int64_t stored = status.st_blocks * block;
    if (stored >= status.st_size / least_share) return;
    refuse(path, "it is hollow: of its " + std::to_string(status.st_size) + " bytes " +
                     std::to_string(stored) +
                     " are on the disk, and the others are missing; copy or export it again");
}

}  // namespace

void refuse(const std::filesystem::path& path, const std::string& reason) {
    throw Error(ErrorKind::input, "cannot read '" + path.string() + "': " + reason);
}

SourceFile load_head(const std::filesystem::path& path, std::size_t count) {
    const FileHandle file = open_regular(path);
    return read_bytes(path, file.get(), count);
}

SourceFile open_file(const std::filesystem::path& path, std::size_t count) {
    const std::shared_ptr<std::FILE> file = open_regular(path);
    SourceFile source = read_bytes(path, file.get(), count);
    std::error_code failure;
    source.file_size = std::filesystem::file_size(path, failure);
    if (failure) refuse(path, failure.message());
    if (source.file_size > source.bytes.size()) source.file = file;
    return source;
}

std::size_t SourceFile::read_at(std::uint64_t offset, void* to, std::size_t count) const {
    if (offset >= size()) return 0;
    count = static_cast<std::size_t>(std::min<std::uint64_t>(count, size() - offset));
    if (count == 0) return 0;
    if (offset + count <= bytes.size()) {
        std::memcpy(to, bytes.data() + offset, count);
        return count;
    }
    if (::fseeko(file.get(), static_cast<off_t>(offset), SEEK_SET) != 0) return 0;
    return std::fread(to, 1, count, file.get());
}

SourceFile load_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
    const FileHandle file = open_regular(path);
    std::error_code failure;
    const std::uintmax_t size = std::filesystem::file_size(path, failure);
    if (failure) refuse(path, failure.message());
    if (size > max_bytes)
        refuse(path, "it has " + std::to_string(size) + " bytes, more than the " + std::to_string(max_bytes) +
                         " that any valid file of its kind needs");
    refuse_hollow(path, file.get());
    return read_bytes(path, file.get(), static_cast<std::size_t>(size));
}

void check_size(const SourceFile& source, unsigned long long width, unsigned long long height) {
    const std::string size = size_text(width, height);
    if (width == 0 || height == 0)
        refuse(source.path, "its size is " + size + "; both sides must be at least 1");
    const auto limit = static_cast<unsigned long long>(source.limits.max_pixels);
    if (width > limit || height > limit || width * height > limit)
        refuse(source.path, "its size is " + size + ", more than the limit of " + std::to_string(limit) +
                                " pixels (" + source.limits.max_pixels_option +
                                "); crop or scale it down first" +
                                (source.limits.max_pixels < kMaxPixels ? ", or raise the limit" : ""));
}

void check_length(const SourceFile& source, unsigned long long sample_bytes, unsigned ratio) {
    if (sample_bytes / ratio <= source.bytes.size()) return;
    refuse(source.path, "truncated or damaged: " + std::to_string(source.bytes.size()) +
                            " bytes cannot hold the " + std::to_string(sample_bytes) +
                            " bytes of samples that the header promises; copy or export it again");
}

}  // namespace hexrelief::readers::codec
