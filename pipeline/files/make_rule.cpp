#include "pipeline/files/make_rule.h"

#include <algorithm>
#include <cctype>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::files {
namespace {

enum class Position { target, source };

bool holds_any(const std::string& name, const char* letters) {
    return name.find_first_of(letters) != std::string::npos;
}

bool is_pattern(const std::string& name) {
    return name.starts_with('~') || holds_any(name, "*?[");
}

// Returns the reason why make would not read `name` back as that name; empty = none. After `;` make expects a
// command. After .SECONDEXPANSION it expands "$(shell ...)" even after a doubled `$`. A name that ends with
// `)` may be an archive member, and a backslash at the end of a line is lost.
std::string obstacle(const std::string& name) {
    if (name.empty()) return "it is empty";
    if (std::ranges::any_of(name, [](unsigned char letter) { return std::iscntrl(letter); }))
        return "it has a control character";
    if (holds_any(name, ";")) return "it has ';'";
    for (const char* call : {"$(", "${"})
        if (name.find(call) != std::string::npos) return "it has '" + std::string(call) + "'";
    if (std::string(") \\").find(name.back()) != std::string::npos)
        return "it ends with '" + name.substr(name.size() - 1) + "'";
    if (is_pattern(name) && holds_any(name, "\\%")) return "it has '\\' or '%' beside a wildcard";
    if (name.size() > 1 && name[0] == '.' && std::isupper(static_cast<unsigned char>(name[1])) &&
        !holds_any(name, "/"))
        return "it is like that of a special target";
    return {};
}

// Returns the name as make reads it. Backslashes quote separators, and backslashes before a separator are
// doubled. Wildcards in brackets are literal, and so is the result of `or`. "./" keeps a name such as
// `export` from being read as a keyword of make.
std::string quoted(const std::filesystem::path& path, Position position) {
    const std::string name = path.string();
    if (const std::string reason = obstacle(name); !reason.empty())
        throw Error(ErrorKind::usage, "--depfile: make cannot read the name '" + name + "': " + reason);
    const std::string separators = position == Position::target ? " #:%" : " #:|";
    std::string text = holds_any(name, "./~") ? "" : "./";
    std::size_t backslashes = 0;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const char letter = name[i];
        if (separators.find(letter) != std::string::npos)
            text.append(backslashes + 1, '\\') += letter;
        else if (letter == '$')
            text += "$$";
        else if (letter == '=' || letter == '&')
            (text += "$(or ").append(1, letter) += ')';
        else if (letter == '*' || letter == '?' || letter == '[' || (letter == '~' && i == 0))
            text.append(1, '[').append(1, letter) += ']';
        else
            text += letter;
        backslashes = letter == '\\' ? backslashes + 1 : 0;
    }
    return text;
}

}  // namespace

std::string make_rule(const std::vector<std::filesystem::path>& targets,
                      const std::vector<std::filesystem::path>& sources) {
    if (targets.empty()) throw Error(ErrorKind::usage, "--depfile: no file is made; give -o FILE");
    const auto as_target = [](const std::filesystem::path& file) { return quoted(file, Position::target); };
    std::string rule = joined(targets, " ", as_target) + ":", alone;
    for (const auto& source : sources) {
        rule += " \\\n  " + quoted(source, Position::source);
        alone += "\n" + as_target(source) + ":\n";
    }
    return rule + "\n" + alone;
}

}  // namespace hexrelief::files
