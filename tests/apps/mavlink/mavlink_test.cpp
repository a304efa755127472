// The vehicle as a MAVLink system: what it tells, and how it answers.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

using mav::mav_result::kAccepted;
using mav::mav_result::kDenied;
using mav::mav_result::kTemporarilyRejected;
using mav::mav_result::kUnsupported;
constexpr uint16_t kArm = mav::mav_cmd::kComponentArmDisarm;
constexpr float kNan = math::canonical_nan<float>();

TEST_F(MavlinkTest, SaysNothingOnALineThatIsNotOpen) {
    is_open_ = {false, false};
    run(2.0);
    EXPECT_EQ(stations_[0].received_bytes + stations_[1].received_bytes, 0U);
}

TEST_F(MavlinkTest, TellsEachStreamAtItsInterval) {
    run(10.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::Heartbeat::kId).size()), 10.0, 1.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::SysStatus::kId).size()), 10.0, 1.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::Attitude::kId).size()), 40.0, 1.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::HomePosition::kId).size()), 5.0, 1.0);
    EXPECT_TRUE(heard(mav::Odometry::kId).empty());
    EXPECT_TRUE(heard(mav::Heartbeat::kId, 1).empty());
}

TEST_F(MavlinkTest, TellsWhereItIs) {
    run(1.0);
    const auto place = heard<mav::GlobalPositionInt>().back();
    EXPECT_EQ(place.alt, 503'000);
    EXPECT_EQ(place.relative_alt, 0);  // disarmed, home is here
    EXPECT_NEAR(place.lat, 474'000'090, 2);
    EXPECT_NEAR(place.lon, 85'000'265, 2);
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    home_ = {.x = 1.0F, .y = 2.0F, .z = -3.0F, .yaw = 0.0F, .valid_lpos = true};
    position_.z = -13.0F;
    run(1.0);
    EXPECT_EQ(heard<mav::GlobalPositionInt>().back().relative_alt, 10'000);
    EXPECT_EQ(heard<mav::HomePosition>().back().altitude, 503'000);
}

TEST_F(MavlinkTest, ANewModeIsToldAtOnce) {
    run(1.05);
    forget();
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    status_.nav_state = Nav::kReturn;
    step();
    ASSERT_EQ(heard(mav::Heartbeat::kId).size(), 1U);
    const auto beat = heard<mav::Heartbeat>().front();
    EXPECT_EQ(beat.custom_mode, 4U << 16 | 5U << 24);
    EXPECT_NE(beat.base_mode & mav::mav_mode_flag::kSafetyArmed, 0U);
}

TEST_F(MavlinkTest, TellsAllModesThatCanBeChosen) {
    line_.bytes_per_s = 600;  // one second for all
    run(1.0);
    forget();
    send_command(mav::mav_cmd::kRequestMessage, {435.0F});
    run(10.0);
    EXPECT_EQ(results(mav::mav_cmd::kRequestMessage), (std::vector<int>{kAccepted}));
    const auto modes = heard<mav::AvailableModes>();
    ASSERT_EQ(modes.size(), 10U);
    for (unsigned i = 0; i < modes.size(); ++i) {
        EXPECT_EQ(modes[i].number_modes, 10U);
        EXPECT_EQ(modes[i].mode_index, i + 1);
        EXPECT_NE(modes[i].standard_mode != 0, modes[i].mode_name[0] != '\0');
        const auto byte = [&](unsigned shift) {
            return static_cast<float>(modes[i].custom_mode >> shift & 0xFFU);
        };
        send_command(mav::mav_cmd::kDoSetMode, {1.0F, byte(16), byte(24)});
        run(0.1);
    }
    EXPECT_EQ(results(mav::mav_cmd::kDoSetMode), std::vector<int>(10, kAccepted));
    EXPECT_EQ(commands_.size(), 10U);
}

TEST_F(MavlinkTest, TellsOneModeByItsNumber) {
    run(1.0);
    send_command(mav::mav_cmd::kRequestMessage, {435.0F, 6.0F});
    send_command(mav::mav_cmd::kRequestMessage, {435.0F, 11.0F});
    run(1.0);
    EXPECT_EQ(results(mav::mav_cmd::kRequestMessage), (std::vector<int>{kAccepted, kDenied}));
    const auto modes = heard<mav::AvailableModes>();
    ASSERT_EQ(modes.size(), 1U);
    EXPECT_EQ(modes[0].mode_index, 6);
    EXPECT_EQ(modes[0].standard_mode, 6);  // mission
    EXPECT_EQ(modes[0].properties, 4U);    // flies by itself
}

TEST_F(MavlinkTest, TellsTheModeOfNow) {
    status_.nav_state = Nav::kMission;
    run(3.0);
    const auto mode = heard<mav::CurrentMode>().back();
    EXPECT_EQ(mode.standard_mode, 6);
    EXPECT_EQ(mode.custom_mode, heard<mav::Heartbeat>().back().custom_mode);
}

TEST_F(MavlinkTest, IntervalsBelongToTheLineThatAsked) {
    is_open_ = {true, true};
    run(1.0);
    send_command(mav::mav_cmd::kSetMessageInterval, {30.0F, 20'000.0F});
    run(0.1);
    EXPECT_EQ(results(mav::mav_cmd::kSetMessageInterval), std::vector<int>{kAccepted});
    forget();
    run(2.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::Attitude::kId).size()), 100.0, 2.0);
    EXPECT_NEAR(static_cast<double>(heard(mav::Attitude::kId, 1).size()), 20.0, 1.0);
    send_command(mav::mav_cmd::kSetMessageInterval, {30.0F, -1.0F});
    run(0.1);
    forget();
    run(1.0);
    EXPECT_TRUE(heard(mav::Attitude::kId).empty());
    send_command(mav::mav_cmd::kSetMessageInterval, {30.0F, 0.0F});
    run(1.0);
    EXPECT_FALSE(heard(mav::Attitude::kId).empty());
}

TEST_F(MavlinkTest, AnIntervalOfWhatWeDoNotSendIsDenied) {
    send_command(mav::mav_cmd::kSetMessageInterval, {60000.0F, 20'000.0F});
    send_command(mav::mav_cmd::kSetMessageInterval, {30.0F, kNan});
    run(0.1);
    EXPECT_EQ(results(mav::mav_cmd::kSetMessageInterval), (std::vector<int>{kDenied, kDenied}));
}

TEST_F(MavlinkTest, TheHeartbeatCannotBeTurnedOff) {
    send_command(mav::mav_cmd::kSetMessageInterval, {0.0F, -1.0F});
    run(3.0);
    EXPECT_GE(heard(mav::Heartbeat::kId).size(), 3U);
}

TEST_F(MavlinkTest, AMessageIsToldBehindTheAnswer) {
    send_command(mav::mav_cmd::kRequestMessage, {148.0F});
    run(0.1);
    const auto& all = stations_[0].heard;
    const auto at = [&](uint32_t id) {
        return std::ranges::find(all, id, &Heard::id) - all.begin();
    };
    EXPECT_EQ(results(mav::mav_cmd::kRequestMessage), std::vector<int>{kAccepted});
    EXPECT_EQ(at(mav::CommandAck::kId) + 1, at(mav::AutopilotVersion::kId));
    send_command(mav::mav_cmd::kRequestMessage, {60000.0F});
    run(0.1);
    EXPECT_EQ(results(mav::mav_cmd::kRequestMessage).back(), static_cast<int>(kUnsupported));
}

TEST_F(MavlinkTest, WhatWeDoNotDoIsUnsupportedAndNothingHappens) {
    for (uint16_t command = 0; command < 3000; ++command) {
        if (command == mav::mav_cmd::kNavTakeoff) continue;
        send_command(command, {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F});
        run(0.03);
        ASSERT_EQ(results(command).size(), 1U) << command;
        forget();
    }
    for (const VehicleCommand& command : commands_) {  // of those that are known
        EXPECT_NE(command.action, VehicleCommand::Action::kArm);
    }
}

TEST_F(MavlinkTest, TheAnswerToACommandGoesToItsSender) {
    is_open_ = {true, true};
    send_command(kArm, {1.0F}, 1, {77, 5});
    run(0.1);
    ASSERT_EQ(commands_.size(), 1U);
    EXPECT_EQ(commands_[0].action, VehicleCommand::Action::kArm);
    ASSERT_EQ(heard<mav::CommandAck>(1).size(), 1U);
    EXPECT_EQ(heard<mav::CommandAck>(1)[0].target_system, 77);
    EXPECT_EQ(heard<mav::CommandAck>(1)[0].target_component, 5);
    EXPECT_TRUE(heard<mav::CommandAck>(0).empty());
}

TEST_F(MavlinkTest, ARepeatedCommandIsDoneOnceAndAnotherOneWaits) {
    answers_ = false;
    send_command(kArm, {1.0F});
    step();
    send_command(kArm, {1.0F});
    send_command(mav::mav_cmd::kNavLand, {});
    run(0.05);
    EXPECT_EQ(commands_.size(), 1U);
    EXPECT_TRUE(results(kArm).empty());
    EXPECT_EQ(results(mav::mav_cmd::kNavLand), std::vector<int>{kTemporarilyRejected});
    ack_ = VehicleCommandAck{.tag = commands_[0].tag};
    run(0.5);
    EXPECT_EQ(results(kArm), std::vector<int>{kAccepted});
}

TEST_F(MavlinkTest, AFloodOfRequestsDoesNotStopTheHeartbeat) {
    line_.bytes_per_s = 1000;
    for (unsigned i = 0; i < 1000; ++i) {
        send(mav::Ping{.time_usec = i + 1, .seq = i});
        send(mav::MissionRequestList{.target_system = 1, .target_component = 1});
        step();
    }
    EXPECT_NEAR(static_cast<double>(heard(mav::Heartbeat::kId).size()), 10.0, 1.0);
}

TEST_F(MavlinkTest, RestartsWhileDisarmed) {
    constexpr uint16_t kRestart = mav::mav_cmd::kPreflightRebootShutdown;
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    send_command(kRestart, {1.0F});
    run(0.1);
    EXPECT_EQ(restarts_, 0U);
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    send_command(kRestart, {2.0F});
    run(0.1);
    EXPECT_EQ(restarts_, 0U);
    send_command(kRestart, {1.0F});
    run(0.1);
    EXPECT_EQ(restarts_, 1U);
    EXPECT_EQ(results(kRestart), (std::vector<int>{kTemporarilyRejected, kUnsupported, kAccepted}));
}

TEST_F(MavlinkTest, ACommandWithoutAnAnswerFails) {
    answers_ = false;
    send_command(kArm, {1.0F});
    run(0.5);
    EXPECT_EQ(results(kArm), std::vector<int>{mav::mav_result::kFailed});
    answers_ = true;
    send_command(kArm, {1.0F});
    run(0.1);
    EXPECT_EQ(results(kArm).back(), static_cast<int>(kAccepted));
}

TEST_F(MavlinkTest, ModesArePx4s) {
    struct Row {
        float main;
        float sub;
        Nav mode;
    };
    for (const Row& row :
         {Row{1, 0, Nav::kManual}, Row{2, 0, Nav::kAltitude}, Row{3, 0, Nav::kPosition},
          Row{4, 2, Nav::kTakeoff}, Row{4, 3, Nav::kHold}, Row{4, 4, Nav::kMission},
          Row{4, 5, Nav::kReturn}, Row{4, 6, Nav::kLand}, Row{7, 0, Nav::kStabilized}}) {
        commands_.clear();
        send_command(mav::mav_cmd::kDoSetMode, {1.0F, row.main, row.sub});
        run(0.1);
        ASSERT_EQ(commands_.size(), 1U);
        EXPECT_EQ(commands_[0].nav_state, static_cast<uint8_t>(row.mode));
    }
    commands_.clear();
    forget();
    send_command(mav::mav_cmd::kDoSetMode, {0.0F, 4.0F, 3.0F});
    send_command(mav::mav_cmd::kDoSetMode, {1.0F, 9.0F, 0.0F});
    run(0.1);
    EXPECT_TRUE(commands_.empty());
    EXPECT_EQ(results(mav::mav_cmd::kDoSetMode), (std::vector<int>{kUnsupported, kUnsupported}));
}

TEST_F(MavlinkTest, GoesToAPlaceAndKeepsWhatIsNotGiven) {
    run(0.1);
    send(mav::CommandInt{.param4 = kNan,
                         .x = 474'000'900,
                         .y = 85'000'000,
                         .z = 510.0F,
                         .command = mav::mav_cmd::kDoReposition,
                         .target_system = 1,
                         .target_component = 1,
                         .frame = 0});
    run(0.1);
    ASSERT_EQ(commands_.size(), 1U);
    EXPECT_EQ(commands_[0].action, VehicleCommand::Action::kGo);
    EXPECT_NEAR(commands_[0].position[0], 10.0F, 0.1F);
    EXPECT_NEAR(commands_[0].position[1], 0.0F, 0.1F);
    EXPECT_NEAR(commands_[0].position[2], -10.0F, 1e-3F);
    EXPECT_TRUE(math::is_nan(commands_[0].heading));
    send_command(mav::mav_cmd::kDoReposition, {-1.0F, 1.0F, kNan, kNan, kNan, kNan, kNan});
    run(0.1);
    for (const float wish : commands_[1].position) EXPECT_TRUE(math::is_nan(wish));
}

TEST_F(MavlinkTest, OthersMessagesAreNotOurs) {
    send(mav::CommandLong{
        .param1 = 1.0F, .command = kArm, .target_system = 2, .target_component = 1});
    send(mav::CommandLong{
        .param1 = 1.0F, .command = kArm, .target_system = 1, .target_component = 9});
    send(mav::Ping{.seq = 1, .target_system = 255, .target_component = 190});
    send(mav::Timesync{.tc1 = 5, .ts1 = 6});
    run(0.1);
    EXPECT_TRUE(commands_.empty());
    EXPECT_TRUE(heard<mav::CommandAck>().empty());
    EXPECT_TRUE(heard<mav::Ping>().empty());
    EXPECT_TRUE(heard<mav::Timesync>().empty());
}

TEST_F(MavlinkTest, AnswersPingAndTimesync) {
    run(1.0);
    send(mav::Ping{.time_usec = 3, .seq = 7});
    send(mav::Timesync{.tc1 = 0, .ts1 = 1234});
    run(0.05);
    ASSERT_EQ(heard<mav::Ping>().size(), 1U);
    EXPECT_EQ(heard<mav::Ping>()[0].seq, 7U);
    EXPECT_EQ(heard<mav::Ping>()[0].target_system, 255);
    ASSERT_EQ(heard<mav::Timesync>().size(), 1U);
    EXPECT_EQ(heard<mav::Timesync>()[0].ts1, 1234);
    EXPECT_EQ(heard<mav::Timesync>()[0].tc1, 1'010'000'000);
}

// 57600 baud carry 5,760 bytes a second; what is wanted is more.
TEST_F(MavlinkTest, ASlowLineIsNeverAskedForMoreThanItCarries) {
    line_.bytes_per_s = 5760;
    has_radio_ = true;
    for (const Stream& stream : kStreams) {
        send_command(mav::mav_cmd::kSetMessageInterval, {static_cast<float>(stream.id), 10'000.0F});
        run(0.1);
    }
    forget();
    stations_[0].received_bytes = 0;
    run(10.0);
    EXPECT_LE(stations_[0].received_bytes, 10 * 5760U + 600U);
    EXPECT_GE(stations_[0].received_bytes, 9 * 5760U);
    EXPECT_GE(heard(mav::Heartbeat::kId).size(), 9U);
    for (const Stream& stream : kStreams) {  // none starves
        if (stream.id == mav::Odometry::kId) continue;
        if (stream.id == mav::OrbitExecutionStatus::kId) continue;  // it flies none
        EXPECT_GE(heard(stream.id).size(), 9U) << stream.id;
    }
}

// Any bytes on both lines: each activation ends, and sends no more than it may (the harness checks
// it). Bytes that ask for a change are answered by the vehicle's own rules; here nothing is armed,
// as the node that decides is not there.
TEST_F(MavlinkTest, AnyBytesEndWell) {
    is_open_ = {true, true};
    uint64_t random = 1;
    const auto next = [&] {
        random = random * 6364136223846793005U + 1442695040888963407U;
        return static_cast<uint32_t>(random >> 33);
    };
    std::vector<mav::Known> known(mav::kKnown.begin(), mav::kKnown.end());
    constexpr unsigned kSteps = 40'000;
    for (unsigned i = 0; i < kSteps; ++i) {
        for (Station& station : stations_) {
            const mav::Known& kind = known[next() % known.size()];
            std::vector<uint8_t> frame{mav::kStart,
                                       static_cast<uint8_t>(next() % 40),
                                       0,
                                       0,
                                       static_cast<uint8_t>(next()),
                                       static_cast<uint8_t>(next() % 3),
                                       static_cast<uint8_t>(next() % 3),
                                       static_cast<uint8_t>(kind.id),
                                       static_cast<uint8_t>(kind.id >> 8),
                                       0};
            for (unsigned n = 0; n < frame[1]; ++n) {
                frame.push_back(static_cast<uint8_t>(next() % 3 == 0 ? next() : next() % 3));
            }
            const auto crc =
                mav::crc16(mav::crc16(mav::kCrcSeed, std::span<const uint8_t>(frame).subspan(1)),
                           kind.crc_extra);
            frame.push_back(static_cast<uint8_t>(crc));
            frame.push_back(static_cast<uint8_t>(crc >> 8));
            if (next() % 8 == 0) frame[next() % frame.size()] ^= static_cast<uint8_t>(next());
            if (station.out.size() < 200) {
                station.out.insert(station.out.end(), frame.begin(), frame.end());
            }
        }
        step();
    }
    EXPECT_GT(heard(mav::CommandAck::kId).size(), 10U);
    EXPECT_GE(heard(mav::Heartbeat::kId).size(), kSteps / 100 - 1);
}

}  // namespace
}  // namespace stator::apps::mavlink
