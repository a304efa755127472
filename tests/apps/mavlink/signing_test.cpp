// Signed frames: which ones count, the time of ours, and how a key comes.
#include "signing.hpp"

#include <cstring>

#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

constexpr uint64_t kSecond = Signing::kSecond;
constexpr uint64_t kNoon = 1'000'000 * kSecond;  // a time of the others
constexpr mav::Address kRadio{51, 68};

// Both lines check signatures, so what comes signed has the right hash. The second one may set the
// key.
class SigningTest : public MavlinkTest {
  protected:
    SigningTest() {
        line_.signs = true;
        is_open_ = {true, true};
        params_.allows2 |= 1 << static_cast<int>(Right::kSign);
    }
    template <class Message>
    void send_signed(const Message& message, uint64_t time, unsigned line = 0,
                     mav::Address from = kGround, uint8_t link = 0) {
        mav::FrameBytes frame;
        const mav::Signed as{.link = link, .time = time};
        mav::with_payload(message, [&](std::span<const uint8_t> payload) {
            frame.put(mav::kKindOf<Message>, payload, stations_[line].sequence++, from, &as);
        });
        send_bytes(frame.bytes(), line);
    }
    // Whether a ping of this time is answered.
    bool is_taken(uint64_t time, unsigned line = 0, mav::Address from = kGround, uint8_t link = 0) {
        forget();
        send_signed(mav::Ping{.seq = 1}, time, line, from, link);
        run(0.05);
        return !heard<mav::Ping>(line).empty();
    }
    bool is_unsigned_taken(unsigned line = 0) {
        forget();
        send(mav::Ping{.seq = 1}, line);
        run(0.05);
        return !heard<mav::Ping>(line).empty();
    }
    // What people read of it.
    std::string set_up(uint8_t first, uint64_t time, unsigned line = 1, uint8_t system = 1) {
        forget();
        adopted_[line].clear();
        mav::SetupSigning setup{
            .initial_timestamp = time, .target_system = system, .target_component = 1};
        setup.secret_key[0] = first;  // a fingerprint, as lines make it
        send_signed(setup, own_time_ += kSecond, line, {254, 190});
        run(0.05);
        const auto texts = heard<mav::Statustext>(line);
        return texts.empty() ? "" : std::string(texts.front().text.data());
    }
    // Of the newest frame of ours.
    uint64_t our_time(unsigned line = 0) {
        const auto& frame = stations_[line].heard.back().frame;
        EXPECT_EQ(frame[2], mav::kIsSigned);
        return mav::time_of(frame);
    }
    uint64_t kept_time() const {
        uint64_t time = 0;
        EXPECT_EQ(kept_.back().kind, StoredRecord::Kind::kSigningTime);
        EXPECT_EQ(kept_.back().length, sizeof time);
        std::memcpy(&time, kept_.back().data.data(), sizeof time);
        return time;
    }
    uint64_t own_time_ = kNoon;
};

TEST_F(SigningTest, a_frame_counts_once) {
    EXPECT_TRUE(is_taken(kNoon));
    EXPECT_FALSE(is_taken(kNoon)) << "replayed";
    EXPECT_FALSE(is_taken(kNoon - 1));
    EXPECT_TRUE(is_taken(kNoon + 1));
    EXPECT_FALSE(is_taken(kNoon + 1, 1)) << "replayed on the other line";
}

TEST_F(SigningTest, each_link_of_each_sender_has_its_own_times) {
    EXPECT_TRUE(is_taken(kNoon));
    EXPECT_TRUE(is_taken(kNoon, 0, kGround, 1));
    EXPECT_TRUE(is_taken(kNoon, 0, {255, 191}));
    EXPECT_FALSE(is_taken(kNoon, 0, kGround, 1));
}

TEST_F(SigningTest, a_new_stream_is_at_most_a_minute_behind) {
    EXPECT_TRUE(is_taken(kNoon));
    EXPECT_TRUE(is_taken(kNoon - 59 * kSecond, 0, {2, 1}));
    EXPECT_FALSE(is_taken(kNoon - 61 * kSecond, 0, {3, 1}));
    run(10.0);
    EXPECT_FALSE(is_taken(kNoon - 51 * kSecond, 0, {4, 1})) << "our time goes on";
}

TEST_F(SigningTest, a_full_table_keeps_those_who_are_known) {
    EXPECT_TRUE(is_taken(kNoon));
    for (uint8_t i = 1; i < Signing::kStreams; ++i) {
        EXPECT_TRUE(is_taken(kNoon, 0, {static_cast<uint8_t>(10 + i), 1}));
    }
    EXPECT_FALSE(is_taken(kNoon + kSecond, 0, {100, 1}));
    EXPECT_TRUE(is_taken(kNoon + kSecond));
}

TEST_F(SigningTest, unsigned_frames_do_not_count_but_those_of_radios) {
    EXPECT_FALSE(is_unsigned_taken());
    send(mav::Heartbeat{.type = mav::mav_type::kGcs});
    run(0.05);
    EXPECT_TRUE(beats_.empty());
    EXPECT_TRUE(heard<mav::Heartbeat>(1).empty() || stations_[1].heard.back().from.system == 1)
        << "nor are they passed on";
    params_.role1 = static_cast<int32_t>(Role::kRadio);
    is_first_ = true;
    run(5.0);
    stations_[0].received_bytes = 0;
    run(5.0);
    const auto usual = stations_[0].received_bytes;
    line_.bytes_per_s = 5760;
    for (int i = 0; i < 60; ++i) {
        send(mav::RadioStatus{.txbuf = 5}, 0, kRadio);
        run(0.05);
    }
    stations_[0].received_bytes = 0;
    for (int i = 0; i < 100; ++i) {
        send(mav::RadioStatus{.txbuf = 40}, 0, kRadio);
        run(0.05);
    }
    EXPECT_LT(stations_[0].received_bytes, usual / 2);
}

TEST_F(SigningTest, a_line_may_take_unsigned_frames) {
    params_.allows2 |= 1 << static_cast<int>(Right::kOpen);
    EXPECT_TRUE(is_unsigned_taken(1));
    EXPECT_FALSE(is_unsigned_taken(0));
    EXPECT_TRUE(is_taken(kNoon, 1));
    EXPECT_FALSE(is_taken(kNoon, 1)) << "what is signed is checked there, too";
}

TEST_F(SigningTest, without_a_key_nothing_is_asked) {
    line_.signs = false;
    EXPECT_TRUE(is_unsigned_taken());
    EXPECT_TRUE(is_taken(kNoon));
    EXPECT_TRUE(is_taken(kNoon)) << "its signature says nothing";
    EXPECT_EQ(stations_[0].heard.back().frame[2], 0);
    EXPECT_TRUE(kept_.empty());
}

TEST_F(SigningTest, our_frames_have_rising_times_and_the_number_of_their_line) {
    is_taken(kNoon);
    forget();
    run(5.0);
    for (unsigned line = 0; line < 2; ++line) {
        uint64_t last = kNoon;
        for (const Heard& message : stations_[line].heard) {
            ASSERT_EQ(message.frame[2], mav::kIsSigned);
            EXPECT_EQ(mav::link_of(message.frame), line);
            EXPECT_GT(mav::time_of(message.frame), last);
            last = mav::time_of(message.frame);
        }
        EXPECT_NEAR(static_cast<double>(last - kNoon), 5.0 * kSecond, 0.3 * kSecond);
    }
}

TEST_F(SigningTest, what_is_kept_is_ahead_of_every_frame_but_less_than_a_minute) {
    is_taken(kNoon);
    for (int i = 0; i < 100; ++i) {
        run(1.0);
        EXPECT_GT(kept_time(), our_time());
        EXPECT_LT(kept_time(), our_time() + 60 * kSecond);
    }
    EXPECT_LE(kept_.size(), 8U) << "seldom";
}

TEST_F(SigningTest, a_restart_goes_on_behind_all_that_was_sent) {
    stored_ = StoredRecord{.kind = StoredRecord::Kind::kSigningTime, .length = 8};
    std::memcpy(stored_->data.data(), &kNoon, sizeof kNoon);
    run(2.0);
    EXPECT_GE(our_time(), kNoon);
    EXPECT_FALSE(is_taken(kNoon - 61 * kSecond)) << "recorded before the restart";
    EXPECT_TRUE(is_taken(kNoon - 20 * kSecond)) << "by who did not hear us yet";
    EXPECT_GT(kept_time(), kNoon);
}

TEST_F(SigningTest, a_key_is_set_where_it_is_allowed) {
    EXPECT_EQ(set_up(7, 5, 0), "signing: not allowed on this line");
    EXPECT_TRUE(adopted_[0].empty());
    EXPECT_EQ(set_up(7, 5), "signing: on, with a new key");
    ASSERT_EQ(adopted_[1].size(), 1U);
    EXPECT_EQ(adopted_[1][0].length, mav::kFingerprintBytes);
    EXPECT_EQ(adopted_[1][0].data[0], 7);
    EXPECT_TRUE(adopted_[0].empty());
    EXPECT_EQ(set_up(7, 5, 1, 2), "") << "for another vehicle";
    EXPECT_TRUE(adopted_[1].empty());
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    EXPECT_EQ(set_up(7, 5), "signing: refused while armed");
    EXPECT_TRUE(adopted_[1].empty());
}

TEST_F(SigningTest, an_unsigned_key_does_not_replace_one) {
    mav::SetupSigning setup{.initial_timestamp = 5, .target_system = 1, .target_component = 1};
    setup.secret_key[0] = 7;
    send(setup, 1);
    run(0.1);
    EXPECT_TRUE(adopted_[1].empty());
    line_.signs = false;
    send(setup, 1);
    run(0.1);
    EXPECT_EQ(adopted_[1].size(), 1U) << "the first one";
}

TEST_F(SigningTest, a_blank_key_turns_signing_off_and_forgets_the_time) {
    is_taken(kNoon);
    EXPECT_EQ(set_up(0, 5), "signing: refused a blank key");
    EXPECT_TRUE(adopted_[1].empty());
    EXPECT_EQ(set_up(0, 0), "signing: off");
    ASSERT_EQ(adopted_[1].size(), 1U);
    EXPECT_EQ(adopted_[1][0].length, 0);
    EXPECT_EQ(kept_.back().length, 0);
}

TEST_F(SigningTest, a_new_key_has_its_time_from_who_sets_it) {
    EXPECT_EQ(set_up(7, kNoon + 1'000 * kSecond), "signing: on, with a new key");
    run(2.0);
    EXPECT_GE(our_time(), kNoon + 1'000 * kSecond);
    EXPECT_GT(kept_time(), our_time());
}

TEST_F(SigningTest, a_key_is_never_passed_on) {
    params_.allows1 |= 1 << static_cast<int>(Right::kSign);
    send_signed(mav::Heartbeat{}, kNoon, 1, {2, 1});
    run(0.1);
    EXPECT_EQ(set_up(7, 5, 0, 2), "");
    EXPECT_TRUE(heard<mav::SetupSigning>(1).empty());
}

TEST_F(SigningTest, signed_frames_for_others_go_on_unchanged) {
    forget();
    send_signed(mav::Heartbeat{}, kNoon, 0, {2, 1}, 9);
    run(0.1);
    const auto found = std::ranges::find_if(
        stations_[1].heard, [](const Heard& message) { return message.from.system == 2; });
    ASSERT_NE(found, stations_[1].heard.end());
    EXPECT_EQ(mav::time_of(found->frame), kNoon);
    EXPECT_EQ(mav::link_of(found->frame), 9);
}

}  // namespace
}  // namespace stator::apps::mavlink
