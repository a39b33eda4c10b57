#include "tests/house/names.h"

#include <cctype>
#include <map>
#include <regex>

namespace hexrelief::testing_house {
namespace {

using Words = std::vector<std::string>;

bool is_letter(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

// Where a comment or a literal that begins at `at` ends; `at` where none does.
std::size_t after_text(const std::string& text, std::size_t at) {
    const auto after = [&](const std::string& end, std::size_t from) {
        const std::size_t found = text.find(end, from);
        return found == std::string::npos ? text.size() : found + end.size();
    };
    if (text.compare(at, 2, "//") == 0) return after("\n", at);
    if (text.compare(at, 2, "/*") == 0) return after("*/", at + 2);
    if (text.compare(at, 2, "R\"") == 0) {
        const std::size_t open = text.find('(', at);
        return after(")" + text.substr(at + 2, open - at - 2) + "\"", open);
    }
    if (text[at] != '"' && text[at] != '\'') return at;
    std::size_t end = at + 1;
    while (end < text.size() && text[end] != text[at]) end += text[end] == '\\' ? 2 : 1;
    return end + 1;
}

// The words and signs of a file, without comments, literals and lines of the preprocessor.
Words words_of(const SourceFile& file) {
    std::string text;
    bool goes_on = false;
    for (const std::string& line : file.lines) {
        const std::size_t first = line.find_first_not_of(" \t");
        const bool left_out = goes_on || (first != std::string::npos && line[first] == '#');
        goes_on = left_out && line.ends_with("\\");
        if (!left_out) text += line + "\n";
    }
    Words words;
    for (std::size_t i = 0; i < text.size();) {
        std::size_t end = after_text(text, i);
        if (end == i) {
            ++end;
            if (is_letter(text[i]))  // in numbers, ' is a part
                while (end < text.size() &&
                       (is_letter(text[end]) || (std::isdigit(text[i]) && text[end] == '\'')))
                    ++end;
            else if (text.compare(i, 2, "::") == 0)
                ++end;
            if (!std::isspace(static_cast<unsigned char>(text[i]))) words.push_back(text.substr(i, end - i));
        }
        i = end;
    }
    return words;
}

std::size_t after_block(const Words& words, std::size_t open) {
    int depth = 0;
    for (std::size_t i = open; i < words.size(); ++i) {
        if (words[i] == "{") ++depth;
        if (words[i] == "}" && --depth == 0) return i + 1;
    }
    return words.size();
}

// True if a block holds nothing but declarations such as `struct Name;`. Pointers to types of another room
// need them where that room must not be included.
bool only_declares_ahead(const Words& words, std::size_t first) {
    std::size_t i = first;
    while (i + 3 < words.size() && (words[i] == "struct" || words[i] == "class") && words[i + 2] == ";")
        i += 3;
    return i > first && words[i] == "}";
}

// The type that a declaration of these words defines, or nothing; specialisations and types inside of others
// have no name of their own.
std::string type_of(const Words& words, bool has_body) {
    std::size_t i = 0;
    if (i < words.size() && words[i] == "template") {
        int depth = 0;
        for (++i; i < words.size(); ++i) {
            depth += (words[i] == "<") - (words[i] == ">");
            if (depth == 0) break;
        }
        ++i;
    }
    const auto is = [&](const char* word) { return i < words.size() && words[i] == word; };
    if (is("using") && i + 2 < words.size() && words[i + 2] == "=") return words[i + 1];
    if (!has_body || (!is("struct") && !is("class") && !is("union") && !is("enum"))) return {};
    while (is("struct") || is("class") || is("union") || is("enum")) ++i;
    if (is("alignas"))
        while (i < words.size() && words[i++] != ")") {
        }
    const bool is_part = i + 1 < words.size() && (words[i + 1] == "<" || words[i + 1] == "::");
    return i < words.size() && is_letter(words[i][0]) && !is_part ? words[i] : std::string();
}

struct Names {
    std::vector<std::string> namespaces, types;
};

Names names_in(const SourceFile& file) {
    const Words words = words_of(file);
    Names names;
    struct Space {
        std::string name;
        bool is_anonymous = false;
    };
    std::vector<Space> open = {{}};
    Words declaration;
    for (std::size_t i = 0; i < words.size();) {
        const std::string& word = words[i];
        if (word == "}") {
            if (open.size() > 1) open.pop_back();
            declaration.clear();
            ++i;
        } else if (word == ";" || word == "{") {
            const bool has_body = word == "{";
            const bool is_inline = !declaration.empty() && declaration[0] == "inline";
            const std::size_t first = is_inline ? 1 : 0;
            if (has_body && declaration.size() > first && declaration[first] == "namespace") {
                Space space = open.back();
                const bool is_named = declaration.size() > first + 1;
                if (!is_named) space.is_anonymous = true;
                if (is_named && !is_inline) {
                    if (!space.name.empty()) space.name += "::";
                    for (std::size_t k = first + 1; k < declaration.size(); ++k) space.name += declaration[k];
                    if (!only_declares_ahead(words, i + 1)) names.namespaces.push_back(space.name);
                }
                open.push_back(space);
                ++i;
            } else {
                const std::string type = type_of(declaration, has_body);
                if (!type.empty() && !open.back().is_anonymous)
                    names.types.push_back(open.back().name + "::" + type);
                i = has_body ? after_block(words, i) : i + 1;
            }
            declaration.clear();
        } else {
            declaration.push_back(word);
            ++i;
        }
    }
    return names;
}

bool is_within(const std::string& inner, const std::string& outer) {
    return inner == outer || inner.starts_with(outer + "::");
}

// The path without the backend's folder, and without the ending.
std::string twin_path(const std::string& path) {
    static const std::regex backend("^(cuda|mesher|pipeline)/|\\.\\w+$");
    return std::regex_replace(path, backend, "");
}

std::string file_name(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

}  // namespace

std::string namespace_of(const std::string& path) {
    // The others have the names of their folders.
    static const std::map<std::string, std::string> kOthers = {
        {"pipeline/data", ""},           {"mesher/common", ""},   {"pipeline/base", ""},
        {"mesher/tiles", "mesh_tiles"},  {"cuda/paper", "paper"}, {"exporters/inspect", "inspect"},
        {"exporters/tileset", "tileset"}};
    static const std::regex folders("(tests/)?(\\w+)/((\\w+)/)?.*");
    std::smatch parts;
    if (!std::regex_match(path, parts, folders)) return "hexrelief";
    const std::string top = parts[2], below = parts[4];
    std::string name = top;
    if (const auto other = kOthers.find(top + "/" + below); other != kOthers.end())
        name = other->second;
    else if (!below.empty() && (top == "pipeline" || top == "mesher"))
        name = below;
    return name.empty() ? "hexrelief" : "hexrelief::" + name;
}

std::vector<std::string> opened_namespaces(const SourceFile& file) {
    return names_in(file).namespaces;
}

std::vector<std::string> defined_types(const SourceFile& file) {
    return names_in(file).types;
}

std::vector<std::string> types_defined_twice(const std::vector<SourceFile>& files) {
    std::map<std::string, std::string> first;
    std::vector<std::string> offences;
    for (const SourceFile& file : files)
        for (const std::string& type : defined_types(file)) {
            const auto [place, is_new] = first.try_emplace(type, file.path);
            if (!is_new && place->second != file.path)
                offences.push_back(type + " is defined in " + place->second + " and in " + file.path);
        }
    return offences;
}

std::vector<std::string> foreign_namespaces(const SourceFile& file) {
    const std::string own = namespace_of(file.path);
    const bool is_test = file.path.starts_with("tests/");
    // What tests share has namespaces of its own; the library's functions are where programs look for them.
    static const std::regex of_tests("hexrelief::(test|testing_\\w+|fuzz|step)");
    std::vector<std::string> offences;
    for (const std::string& name : opened_namespaces(file)) {
        const bool is_step = name == "hexrelief::step" && file.path.find("_step") != std::string::npos;
        const bool is_public = name == "hexrelief" && own == "hexrelief::library";
        if (!name.starts_with("hexrelief") || is_within(name, own) || is_step || is_public ||
            (is_test && std::regex_match(name, of_tests)))
            continue;
        offences.push_back(file.path + " opens " + name + ", and its room is " + own);
    }
    return offences;
}

std::vector<std::string> headers_named_alike(const std::vector<SourceFile>& files) {
    std::map<std::string, std::string> first;
    std::vector<std::string> offences;
    for (const SourceFile& file : files) {
        if (!file.path.ends_with(".h") && !file.path.ends_with(".cuh")) continue;
        const auto [place, is_new] = first.try_emplace(file_name(file.path), file.path);
        if (!is_new && twin_path(place->second) != twin_path(file.path))
            offences.push_back(place->second + " and " + file.path);
    }
    return offences;
}

}  // namespace hexrelief::testing_house
