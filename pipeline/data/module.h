// Finds the program's own optional libraries and programs, which are opened or started only when needed
// because they depend on many libraries.
#pragma once

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace hexrelief {

// Returns the path of the file that this code is part of: the program, a shared library or the Python module.
inline std::filesystem::path own_object() {
    static const char inside = 0;
    Dl_info own{};
    link_map* map = nullptr;
    std::error_code failure;
    const bool is_found = dladdr1(&inside, &own, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) != 0;
    const bool is_program = !is_found || map == nullptr || *map->l_name == '\0';
    return std::filesystem::canonical(is_program ? "/proc/self/exe" : map->l_name, failure);
}

// Returns the folder of the modules for an object that lies in the folder `own`: the build folder if `own`
// lies in it; PREFIX/lib/hexrelief if `own` is a folder of PREFIX that programs, libraries or Python modules
// are installed into; else empty. No other folder is searched, because anybody might have put a file there.
inline std::filesystem::path module_folder(const std::filesystem::path& own) {
    namespace fs = std::filesystem;
    const fs::path build = HEXRELIEF_BUILD_FOLDER;
    if (!build.empty() &&
        std::mismatch(build.begin(), build.end(), own.begin(), own.end()).first == build.end())
        return build;
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

// True if the file belongs to the superuser or to the owner of `object`, and nobody else may write to it.
inline bool is_trusted(const std::filesystem::path& file, const std::filesystem::path& object) {
    struct stat of_file {
    }, of_object{};
    return stat(file.c_str(), &of_file) == 0 && stat(object.c_str(), &of_object) == 0 &&
           (of_file.st_uid == 0 || of_file.st_uid == of_object.st_uid) && (of_file.st_mode & S_IWOTH) == 0;
}

struct ModulePlace {
    std::filesystem::path path;
    std::string failure = {};  // why `path` is empty
};

// Looks for the file in module_folder(). It must belong to the superuser or to the program's owner, and not
// be writable for all.
inline ModulePlace find_module(const std::string& file) {
    const std::filesystem::path object = own_object(), folder = module_folder(object.parent_path());
    std::error_code failure;
    if (folder.empty())
        return {{},
                file + " is looked for in an installation's lib/hexrelief only, and " + object.string() +
                    " is in none"};
    const std::filesystem::path path = folder / file;
    if (!std::filesystem::exists(path, failure)) return {{}, file + " is not in " + folder.string()};
    if (!is_trusted(path, object))
        return {
            {},
            path.string() + " has another owner than " + object.string() + ", or anybody may write to it"};
    return {path};
}

struct ModuleFunction {
    void* function = nullptr;
    std::string failure;  // why `function` is null
};

// Opens the library `file` that find_module() finds, and looks up `function` in it. It is never closed.
inline ModuleFunction open_module(const std::string& file, const char* function) {
    const auto [path, failure] = find_module(file);
    if (path.empty()) return {nullptr, failure};
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return {nullptr, dlerror()};
    if (void* const symbol = dlsym(library, function)) return {symbol, {}};
    return {nullptr, path.string() + " is not hexrelief's; reinstall it"};
}

}  // namespace hexrelief
