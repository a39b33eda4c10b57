#include "pipeline/files/sha256.h"

#include <gtest/gtest.h>

#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::files {
namespace {

TEST(Sha256, GivesThePublishedDigests) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "empty", "");
    test::write_text(folder / "abc", "abc");
    test::write_text(folder / "million", std::string(1000000, 'a'));
    EXPECT_EQ(sha256_of_file(folder / "empty"),
              "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sha256_of_file(folder / "abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256_of_file(folder / "million"),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    EXPECT_THROW(sha256_of_file(folder / "none"), Error);
}

}  // namespace
}  // namespace hexrelief::files
