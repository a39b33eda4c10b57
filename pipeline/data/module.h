// Libraries of the program's own that are opened only when they are needed, because they bring in others.
#pragma once

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>

namespace hexrelief {

// The program, or the shared library or Python module that this is a part of.
inline std::filesystem::path own_object() {
    static const char inside = 0;
    Dl_info own{};
    link_map* map = nullptr;
    std::error_code failure;
    const bool is_found = dladdr1(&inside, &own, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) != 0;
    const bool is_program = !is_found || map == nullptr || *map->l_name == '\0';
    return std::filesystem::canonical(is_program ? "/proc/self/exe" : map->l_name, failure);
}

// Where the modules of an object in the folder `own` lie: of a build in its root; of an installation in
// PREFIX/lib/hexrelief, where `own` is the folder of PREFIX that programs, libraries or Python modules are
// installed into. Empty = neither. Nowhere else is looked, for what is there may be anybody's.
inline std::filesystem::path module_folder(const std::filesystem::path& own) {
    namespace fs = std::filesystem;
    const fs::path build = HEXRELIEF_BUILD_FOLDER;
    if (std::mismatch(build.begin(), build.end(), own.begin(), own.end()).first == build.end()) return build;
    for (const fs::path place :
         {HEXRELIEF_PROGRAM_FOLDER, HEXRELIEF_LIBRARY_FOLDER, "lib/python*/dist-packages/hexrelief"}) {
        fs::path prefix = own;
        bool is_there = true;
        for (auto part = place.end(); part != place.begin(); prefix = prefix.parent_path()) {
            const std::string wanted = *--part, name = prefix.filename();
            is_there = is_there && (wanted == "python*" ? name.starts_with("python") : name == wanted);
        }
        if (is_there) return prefix / "lib" / "hexrelief";
    }
    return {};
}

// Whether a file is the superuser's, or of the one who owns `object`.
inline bool is_trusted(const std::filesystem::path& file, const std::filesystem::path& object) {
    struct stat of_file {
    }, of_object{};
    return stat(file.c_str(), &of_file) == 0 && stat(object.c_str(), &of_object) == 0 &&
           (of_file.st_uid == 0 || of_file.st_uid == of_object.st_uid);
}

struct ModuleFunction {
    void* function = nullptr;
    std::string failure;  // why there is none
};

// Opens the library `file` of module_folder() for good, where it has the program's owner or is the
// superuser's.
inline ModuleFunction open_module(const std::string& file, const char* function) {
    const std::filesystem::path object = own_object(), folder = module_folder(object.parent_path());
    std::error_code failure;
    if (folder.empty())
        return {nullptr, file + " is looked for in an installation's lib/hexrelief only, and " +
                             object.string() + " is in none"};
    const std::filesystem::path path = folder / file;
    if (!std::filesystem::exists(path, failure)) return {nullptr, file + " is not in " + folder.string()};
    if (!is_trusted(path, object))
        return {nullptr, path.string() + " has another owner than " + object.string()};
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return {nullptr, dlerror()};
    if (void* const symbol = dlsym(library, function)) return {symbol, {}};
    return {nullptr, path.string() + " is not hexrelief's; reinstall it"};
}

}  // namespace hexrelief
