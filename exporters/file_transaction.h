// Output files that appear whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief {

// A set of files that appear together or not at all: each is written to a temporary beside its target; commit() renames
// them all; without commit() (an exception, an interrupt) the destructor removes what was written.
class FileTransaction {
  public:
    FileTransaction() = default;
    FileTransaction(const FileTransaction&) = delete;
    FileTransaction& operator=(const FileTransaction&) = delete;
    ~FileTransaction();
    // Throws Error(output) naming the path and the system's reason.
    void write(const std::filesystem::path& path, const void* data, std::size_t bytes);
    void write(const std::filesystem::path& path, const std::string& text) { write(path, text.data(), text.size()); }
    void write(const std::filesystem::path& path, const std::vector<std::uint8_t>& data) {
        write(path, data.data(), data.size());
    }
    void commit();

  private:
    struct Pending {
        std::filesystem::path temporary, target;
    };
    std::vector<Pending> pending_;
};

}  // namespace hexrelief
