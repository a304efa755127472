// Runs the navigation filter's operations, and those of geodesy, and counts their instructions.
#pragma once

#include "../../../../../apps/navigation/filter.hpp"
#include "cost_ports.hpp"
#include "stator/geodesy.hpp"

namespace stator::apps::cost {

using namespace navigation;

class Cost {
  public:
    void step(CostPorts& ports);

  private:
    void count_geodesy(double run);

    Filter filter_;
    MotionWindow window_;
    NavigationParams params_{};
    uint32_t runs_ = 0;
    uint64_t time_us_ = 0;
    // Instructions: of reading the counter, and the most of each operation.
    uint32_t reading_ = 0;
    uint32_t predict_ = 0;
    uint32_t fuse_one_ = 0;
    uint32_t fuse_two_ = 0;
    uint32_t fuse_heading_ = 0;
    uint32_t output_ = 0;
    uint32_t frame_ = 0;
    uint32_t local_ = 0;
    uint32_t global_ = 0;
};

}  // namespace stator::apps::cost
