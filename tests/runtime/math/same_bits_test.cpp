// Every compiler, level of optimisation and machine has to get the committed hashes.
//
// expected_hashes.inc is what print_hashes prints. It changes only with a function's results or
// with the arguments in same_bits.cpp: then renew it, and say why in the commit.
#include "same_bits.hpp"

#include <gtest/gtest.h>

namespace stator::math {
namespace {

const NamedHash kExpected[] = {
#include "expected_hashes.inc"
};

TEST(SameBits, HashesAreTheCommittedOnes) {
    const std::vector<NamedHash> hashes = result_hashes();
    ASSERT_EQ(hashes.size(), std::size(kExpected));
    for (std::size_t i = 0; i < hashes.size(); ++i) {
        EXPECT_EQ(hashes[i].name, kExpected[i].name);
        EXPECT_EQ(hashes[i].hash, kExpected[i].hash) << hashes[i].name;
    }
}

}  // namespace
}  // namespace stator::math
