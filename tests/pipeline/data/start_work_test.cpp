#include "pipeline/data/start_work.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/expect_error.h"

namespace hexrelief {
namespace {

TEST(StartWork, GivesTheResultAndPassesErrorsOn) {
    for (const int threads : {1, 2}) {
        EXPECT_EQ(start_work(threads, [] { return 7; }).get(), 7);
        auto failing = start_work(threads, []() -> int { throw Error(ErrorKind::input, "no picture"); });
        EXPECT_EQ(test::error_of([&] { failing.get(); }), "no picture");
    }
}

TEST(StartWork, WithOneThreadIsDoneByTheCaller) {
    const auto who = [] { return std::this_thread::get_id(); };
    EXPECT_EQ(start_work(1, who).get(), std::this_thread::get_id());
    EXPECT_NE(start_work(2, who).get(), std::this_thread::get_id());
}

TEST(StartWork, IsWaitedForWhereItsFutureEnds) {
    bool done = false;
    {
        const auto future = start_work(2, [&] { done = true; });
    }
    EXPECT_TRUE(done);
}

}  // namespace
}  // namespace hexrelief
