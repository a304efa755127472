// The bxCAN port alone, with the model of its registers: what its tests share.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "bxcan_model.hpp"
#include "bxcan_wire.hpp"

namespace stator::testing {

struct Bxcan : ::testing::Test {
    ~Bxcan() override { EXPECT_EQ(model.violations(), 0U) << "written while it was protected"; }

    // With a bus that is idle.
    void start() {
        for (int i = 0; i < 5; ++i) {
            run();
            model.recessive(1);
        }
        ASSERT_EQ(port.state(), CanInterfaceStatus::State::kErrorActive);
    }
    void run(uint64_t step_us = 1000) { port.begin(now_us += step_us); }
    CanSend send(uint32_t id, uint8_t first = 0) { return port.send(frame(id, now_us, first)); }
    CanInterfaceStatus counts() const {
        CanInterfaceStatus status{};
        port.count(status);
        return status;
    }
    std::vector<uint32_t> transmit_all() {
        std::vector<uint32_t> ids;
        while (const auto sent = model.transmit()) ids.push_back(sent->identifier >> 3);
        return ids;
    }
    std::vector<uint32_t> taken_back() {
        std::vector<uint32_t> firsts;
        for (CanFrame f; port.take_back(f);) firsts.push_back(f.data[0]);
        return firsts;
    }
    std::vector<CanFrame> received() {
        std::vector<CanFrame> frames;
        for (CanFrame f; port.receive(f, now_us);) frames.push_back(f);
        return frames;
    }

    BxcanModel model;
    BxcanPort<BxcanWire> port{{&model}, bxcan::bit_timing(42'000'000, 1'000'000)};
    uint64_t now_us = 1'000'000;
};

}  // namespace stator::testing
