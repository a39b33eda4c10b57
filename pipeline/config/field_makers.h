// Makes rows of the field table from members of the configuration. Only the table includes this header.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipeline/config/fields.h"

namespace hexrelief::config {

inline constexpr double kAny = 1e9;                     // "any number": beyond all sensible values
inline constexpr double kMaxSeed = 9007199254740991.0;  // 2^53 - 1: JSON readers keep it exactly

template <typename Access>
using Member = std::remove_reference_t<decltype(std::declval<Access>()(std::declval<Config&>()))>;

template <typename T>
FieldValue to_value(const T& member) {
    if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, std::string>)
        return member;
    else if constexpr (std::is_floating_point_v<T>)
        return static_cast<double>(member);
    else
        return static_cast<long long>(member);
}

template <typename T>
void from_value(T& member, const FieldValue& value) {
    if constexpr (std::is_same_v<T, bool>)
        member = std::get<bool>(value);
    else if constexpr (std::is_same_v<T, std::string>)
        member = std::get<std::string>(value);
    else if constexpr (std::is_floating_point_v<T>)
        member = static_cast<T>(std::get<double>(value));
    else
        member = static_cast<T>(std::get<long long>(value));
}

// Returns a field whose value is its member; `field` holds everything except get and set.
template <typename Access>
Field plain(Field field, Access access) {
    field.get = [access](const Config& config) { return to_value(access(const_cast<Config&>(config))); };
    field.set = [access](Config& config, const FieldValue& value) { from_value(access(config), value); };
    return field;
}

template <typename Access>
Field number(const std::string& path, Access access, const std::string& unit, const ValueRange& range,
             const std::string& help, const FieldOption& option = {}) {
    constexpr FieldType type =
        std::is_floating_point_v<Member<Access>> ? FieldType::real : FieldType::integer;
    return plain({path, unit, help, type, range, {}, option, {}, {}}, access);
}

template <typename Access>
Field flag(const std::string& path, Access access, const std::string& help, const FieldOption& option = {}) {
    return plain({path, "", help, FieldType::boolean, {}, {}, option, {}, {}}, access);
}

template <typename Access>
Field text(const std::string& path, Access access, const std::string& help, const FieldOption& option = {}) {
    return plain({path, "", help, FieldType::text, {}, {}, option, {}, {}}, access);
}

template <typename Access>
Field file(const std::string& path, Access access, const std::string& help, const FieldOption& option = {}) {
    return plain({path, "", help, FieldType::file, {}, {}, option, {}, {}}, access);
}

// Returns a field whose NaN, or 0 of an int, means "not given" and is null in YAML.
template <typename Access>
Field optional(const std::string& path, Access access, const std::string& unit, const ValueRange& range,
               const std::string& help, const FieldOption& option = {}) {
    using Value = Member<Access>;
    constexpr Value kNone = std::is_floating_point_v<Value> ? static_cast<Value>(kNotGiven) : 0;
    Field field = number(path, access, unit, range, help, option);
    field.is_optional = true;
    field.get = [access, get = field.get](const Config& config) -> FieldValue {
        const Value value = access(const_cast<Config&>(config));
        return value == kNone || std::isnan(static_cast<double>(value)) ? FieldValue{} : get(config);
    };
    field.set = [access, set = field.set](Config& config, const FieldValue& value) {
        if (std::holds_alternative<std::monostate>(value))
            access(config) = kNone;
        else
            set(config, value);
    };
    return field;
}

template <typename Access>
Field choice(const std::string& path, Access access, const std::vector<std::string>& names,
             const std::string& help, const FieldOption& option = {}) {
    Field field{path, "", help, FieldType::choice, {}, names, option, {}, {}};
    field.get = [access, names](const Config& config) -> FieldValue {
        return names.at(static_cast<std::size_t>(access(const_cast<Config&>(config))));
    };
    field.set = [access, names](Config& config, const FieldValue& value) {
        const auto at = std::ranges::find(names, std::get<std::string>(value));
        access(config) = static_cast<Member<Access>>(at - names.begin());
    };
    return field;
}

#define MEMBER(name) ([](Config & c) -> auto& { return c.name; })
#define KEY(name) #name, MEMBER(name)  // a key that is named as its member

inline void append(std::vector<Field>& table, std::vector<Field> fields) {
    std::move(fields.begin(), fields.end(), std::back_inserter(table));
}

// Return the rows of input_fields.cpp.
std::vector<Field> input_fields();
std::vector<Field> export_fields();

}  // namespace hexrelief::config
