// The folders of the house and its source files, as text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::testing_house {

// A folder and those whose headers it may include beside its own, the standard library's and external ones.
struct Room {
    std::string folder;
    // Folders, which cover all below them; files; or a folder's files by their ending: "mesher/*_step.h".
    std::vector<std::string> may_include;
};

const std::vector<Room>& rooms();

struct SourceFile {
    std::string path;  // relative to the repository's root
    std::vector<std::string> lines;
};

// All files of C++ and CUDA below `folder`, sorted; folders whose name starts with "build" or "." are left
// out.
std::vector<SourceFile> source_files(const std::filesystem::path& root, const std::string& folder);
// Those of the whole project.
std::vector<SourceFile> all_sources();
// The same for CMakeLists.txt and *.cmake.
std::vector<SourceFile> cmake_files(const std::filesystem::path& root);

// The same for everything else that is written by hand: CMake, scripts and documents.
std::vector<SourceFile> other_files(const std::filesystem::path& root);

// The path in a line that includes with quotes, else empty.
std::string quoted_include(const std::string& line);
// The path in a line that includes with angle brackets, else empty.
std::string angled_include(const std::string& line);

// The innermost room whose folder holds the path, or nullptr.
const Room* room_of(const std::string& path);

// One line each: an include that the path's room does not allow, or that is not spelt from the root.
std::vector<std::string> include_offences(const SourceFile& file);

// "a -> b -> a" where folders include each other in a circle, else empty.
std::string include_cycle(const std::vector<SourceFile>& files);

}  // namespace hexrelief::testing_house
