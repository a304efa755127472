// When a request to restart is handed to the board.
#include <gtest/gtest.h>

#include "system_board.hpp"

namespace stator::drivers::system::board {
namespace {

int restarts = 0;

struct System : ::testing::Test {
    System() { restarts = 0; }
    // Activations each 50 ms.
    void run(unsigned activations, const RestartRequest* asked = nullptr) {
        for (unsigned i = 0; i < activations; ++i) {
            now_us += 50'000;
            VehicleStatus status{.arming_state = armed ? VehicleStatus::ArmingState::kArmed
                                                       : VehicleStatus::ArmingState::kDisarmed};
            SystemPorts ports{
                .now = now_us,
                .restart = asked == nullptr ? Input<RestartRequest>() : Input(*asked, i == 0),
                .status = is_known ? Input(status) : Input<VehicleStatus>()};
            driver.step(ports);
        }
    }

    SystemBoard::Device device{.restart = [] { ++restarts; }};
    SystemBoard driver{device};
    RestartRequest request{};
    bool armed = false;
    bool is_known = true;
    uint64_t now_us = 1'000'000;
};

TEST_F(System, a_request_is_done_once_the_answer_had_half_a_second) {
    run(20);
    EXPECT_EQ(restarts, 0);
    run(10, &request);
    EXPECT_EQ(restarts, 0);
    EXPECT_FALSE(device.restarts);
    run(1, nullptr);
    EXPECT_EQ(restarts, 1);
    EXPECT_TRUE(device.restarts);
    run(100);
    EXPECT_EQ(restarts, 1) << "once";
}

TEST_F(System, who_asks_again_and_again_does_not_put_it_off) {
    for (unsigned i = 0; i < 3; ++i) run(4, &request);
    EXPECT_EQ(restarts, 1);
}

TEST_F(System, who_arms_meanwhile_flies) {
    run(5, &request);
    armed = true;
    run(1);
    armed = false;
    run(100);
    EXPECT_EQ(restarts, 0);
}

TEST_F(System, without_a_status_nothing_restarts) {
    is_known = false;
    run(100, &request);
    EXPECT_EQ(restarts, 0);
}

TEST_F(System, a_board_that_cannot_restart_goes_on) {
    device = {};
    run(100, &request);
    EXPECT_FALSE(device.restarts);
}

}  // namespace
}  // namespace stator::drivers::system::board
