// Expects an Error of one kind whose message contains a given text.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "pipeline/data/error.h"

namespace hexrelief::stages {

template <typename Call>
void expect_error(ErrorKind kind, const std::string& part, Call call) {
    try {
        call();
        ADD_FAILURE() << "no error, expected one with '" << part << "'";
    } catch (const Error& error) {
        EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(kind)) << error.what();
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos)
            << "more than one line: " << error.what();
    }
}

}  // namespace hexrelief::stages
