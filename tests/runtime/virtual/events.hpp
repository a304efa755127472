// What happens around a graph under test, and when.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <map>

#include "stator/virtual.hpp"

namespace stator::testing {

extern std::multimap<uint64_t, std::function<void()>> events;

// Starts the graph of this process, which can be started once.
class GraphTest : public ::testing::Test {
  protected:
    void SetUp() override {
        ASSERT_EQ(executor.pending, nullptr) << "one case a process: ctest, or --gtest_filter";
        start();
    }
};

}  // namespace stator::testing
