// Expects Errors, and texts that contain others.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "pipeline/data/error.h"

namespace hexrelief::test {

// Returns the message, of one line, of the Error of this kind that the call throws; empty if it throws none.
template <typename Call>
std::string refusal_of(Call&& call, ErrorKind kind = ErrorKind::input) {
    try {
        call();
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(error.kind(), kind) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line: " << message;
        return message;
    }
    return {};
}

// As refusal_of(), of a call that must throw an Error.
template <typename Call>
std::string error_of(Call&& call, ErrorKind kind = ErrorKind::input) {
    const std::string message = refusal_of(call, kind);
    EXPECT_NE(message, "") << "nothing was thrown";
    return message;
}

}  // namespace hexrelief::test

// Expects that `text` contains `part`; shows both if not.
#define EXPECT_CONTAINS(text, part)                                                                          \
    EXPECT_PRED2([](std::string_view a, std::string_view b) { return a.find(b) != std::string_view::npos; }, \
                 text, part)
