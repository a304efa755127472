// Frames for others go on to the other line.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

constexpr mav::Address kCamera{1, 100};  // of our system
constexpr mav::Address kOther{7, 1};     // another vehicle
constexpr mav::Address kComputer{1, 191};

class RouterTest : public MavlinkTest {
  protected:
    RouterTest() { is_open_ = {true, true}; }

    // What was heard on a line that is not the vehicle's own.
    std::vector<Heard> forwarded(unsigned line) const {
        std::vector<Heard> found;
        for (const Heard& heard : stations_[line].heard) {
            if (!(heard.from == mav::Address{1, 1})) found.push_back(heard);
        }
        return found;
    }
    void send_to(uint8_t system, uint8_t component, unsigned line) {
        send(mav::CommandLong{.param1 = 1.0F,
                              .command = 3000,
                              .target_system = system,
                              .target_component = component},
             line);
    }
    // Lets the vehicle hear it.
    void hear(mav::Address from, unsigned line) {
        send(mav::Heartbeat{.type = 2}, line, from);
        run(0.1);
        forget();
    }
};

TEST_F(RouterTest, what_is_for_all_goes_to_the_other_line_and_not_back) {
    send(mav::Heartbeat{.custom_mode = 5, .type = 6}, 0);
    const std::vector<uint8_t> sent(stations_[0].out.begin(), stations_[0].out.end());
    run(0.1);
    ASSERT_EQ(forwarded(1).size(), 1U);
    EXPECT_EQ(forwarded(1)[0].frame, sent);
    EXPECT_TRUE(forwarded(0).empty());
}

TEST_F(RouterTest, what_is_typed_into_a_console_stays_on_its_line) {
    mav::SerialControl message{.device = 10, .count = 1};
    send(message, 0);
    run(0.1);
    EXPECT_TRUE(forwarded(1).empty());
    hear(kOther, 1);
    message.target_system = kOther.system;
    send(message, 0);
    run(0.1);
    EXPECT_EQ(forwarded(1).size(), 1U);
}

TEST_F(RouterTest, what_is_for_another_one_goes_only_where_that_was_heard) {
    send_to(kOther.system, kOther.component, 0);
    run(0.1);
    EXPECT_TRUE(forwarded(1).empty());
    hear(kOther, 0);  // on the line where the question comes from
    send_to(kOther.system, kOther.component, 0);
    run(0.1);
    EXPECT_TRUE(forwarded(0).empty() && forwarded(1).empty());
    hear(kOther, 1);
    send_to(kOther.system, kOther.component, 0);
    send_to(kOther.system, 0, 0);
    send_to(kOther.system, 99, 0);
    run(0.1);
    EXPECT_EQ(forwarded(1).size(), 2U);
    EXPECT_TRUE(heard(mav::CommandAck::kId).empty());
}

TEST_F(RouterTest, what_is_for_us_stays_here) {
    hear(kCamera, 1);
    send_to(1, 1, 0);
    run(0.1);
    EXPECT_TRUE(forwarded(1).empty());
    EXPECT_EQ(heard(mav::CommandAck::kId).size(), 1U);
    // For another component of our system: not for us. For all of them: for us, too.
    forget();
    send_to(1, kCamera.component, 0);
    run(0.1);
    EXPECT_EQ(forwarded(1).size(), 1U);
    EXPECT_TRUE(heard(mav::CommandAck::kId).empty());
    send_to(1, 0, 0);
    run(0.1);
    EXPECT_EQ(forwarded(1).size(), 2U);
    EXPECT_EQ(heard(mav::CommandAck::kId).size(), 1U);
}

TEST_F(RouterTest, private_messages_stay_here) {
    hear(kOther, 1);
    send(mav::RadioStatus{.rxerrors = 3}, 0);
    send(mav::SetupSigning{.target_system = kOther.system, .target_component = 1}, 0);
    send(mav::SetupSigning{}, 0);
    run(0.1);
    EXPECT_TRUE(forwarded(1).empty());
}

TEST_F(RouterTest, our_own_frames_that_come_back_end_here) {
    send(mav::Heartbeat{.custom_mode = 12345, .type = 2}, 0, {1, 1});
    run(0.1);
    for (const auto& beat : heard<mav::Heartbeat>(1)) EXPECT_NE(beat.custom_mode, 12345U);
}

// Frames of messages that we do not know, and signed ones, byte by byte.
TEST_F(RouterTest, frames_go_on_unchanged) {
    const std::vector<uint8_t> unknown{0xFD, 2, 0, 0, 7, 3, 9, 0xF0, 0xF0, 0xF0, 1, 2, 0x12, 0x34};
    std::vector<uint8_t> with_signature{0xFD, 2, 1, 0, 7, 3, 9, 0xF0, 0xF0, 0xF0, 1, 2, 0x12, 0x34};
    for (uint8_t i = 1; i <= mav::kSignatureBytes; ++i) with_signature.push_back(i);
    send_bytes(unknown);
    send_bytes(with_signature);
    send_bytes(unknown);
    run(0.1);
    ASSERT_EQ(forwarded(1).size(), 3U);
    EXPECT_EQ(forwarded(1)[0].frame, unknown);
    EXPECT_EQ(forwarded(1)[1].frame, with_signature);
    EXPECT_EQ(forwarded(1)[2].frame, unknown);
}

// 57600 baud: half of it at most is for others, and the vehicle's own streams go on.
TEST_F(RouterTest, a_flood_of_others_leaves_the_line_to_us) {
    line_.bytes_per_s = 5760;
    run(1.0);
    forget();
    for (unsigned i = 0; i < 1000; ++i) {
        if (stations_[1].out.size() < 300) {
            send(mav::Odometry{.time_usec = i + 1, .quality = 1}, 1, kComputer);
        }
        step();
    }
    std::size_t bytes = 0;
    for (const Heard& frame : forwarded(0)) bytes += frame.frame.size();
    EXPECT_GT(bytes, 10 * 2880 * 8 / 10);
    EXPECT_LE(bytes, 10 * 2880 + 600U);
    EXPECT_NEAR(static_cast<double>(heard(mav::Heartbeat::kId).size()), 10.0, 1.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::Attitude::kId).size()), 40.0, 4.0);
}

TEST_F(RouterTest, invented_addresses_do_not_push_out_those_that_are_heard) {
    hear(kOther, 1);
    for (unsigned i = 0; i < 300; ++i) {
        send(mav::Heartbeat{.type = 2}, 0, {static_cast<uint8_t>(10 + i % 200), 9});
        run(0.05);
    }
    forget();
    send_to(kOther.system, kOther.component, 0);
    run(0.1);
    ASSERT_EQ(forwarded(1).size(), 1U);
    // Silent for a minute, they make room.
    run(70.0);
    hear({8, 1}, 1);
    send_to(8, 1, 0);
    run(0.1);
    EXPECT_EQ(forwarded(1).size(), 1U);
}

}  // namespace
}  // namespace stator::apps::mavlink
