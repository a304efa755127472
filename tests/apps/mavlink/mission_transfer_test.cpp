// Plans go to the mission device and back, whole or not at all.
#include "mission_transfer.hpp"

#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

namespace result = mav::mav_mission_result;
constexpr float kNan = math::canonical_nan<float>();

class MissionTransferTest : public MavlinkTest {
  protected:
    static mav::MissionItemInt item(uint16_t seq, uint8_t list = 0) {
        mav::MissionItemInt item{.param1 = 1.0F,
                                 .param4 = kNan,
                                 .x = 474'000'000 + seq,
                                 .y = 85'000'000,
                                 .z = 10.0F,
                                 .seq = seq,
                                 .command = 16,
                                 .target_system = 1,
                                 .target_component = 1,
                                 .frame = mav::mav_frame::kGlobalRelativeAltInt,
                                 .autocontinue = 1};
        if (list == 1) item.command = 5001;
        if (list == 2) item.command = 5100;
        item.mission_type = list;
        return item;
    }
    void send_count(uint16_t count, uint8_t list = 0, mav::Address from = kGround,
                    unsigned line = 0) {
        mav::MissionCount message{.count = count, .target_system = 1, .target_component = 1};
        message.mission_type = list;
        send(message, line, from);
    }
    std::vector<mav::MissionAck> acks() { return heard<mav::MissionAck>(); }
    // The result; every request is answered after `delay` activations.
    int upload(uint16_t count, uint8_t list = 0, unsigned delay = 1) {
        forget();
        send_count(count, list);
        std::size_t answered = 0;
        for (unsigned i = 0; i < 3000 && acks().empty(); ++i) {
            step();
            const auto requests = heard<mav::MissionRequestInt>();
            if (i % delay != 0 || answered == requests.size()) continue;
            EXPECT_EQ(requests.back().target_system, kGround.system);
            EXPECT_EQ(requests.back().mission_type, list);
            send(item(requests.back().seq, list));
            answered = requests.size();
        }
        EXPECT_EQ(acks().size(), 1U);
        return acks().empty() ? -1 : acks().front().type;
    }
    std::vector<mav::MissionItemInt> download(uint8_t list = 0) {
        forget();
        mav::MissionRequestList all{.target_system = 1, .target_component = 1};
        all.mission_type = list;
        send(all);
        run(0.1);
        const auto counts = heard<mav::MissionCount>();
        EXPECT_EQ(counts.size(), 1U);
        for (uint16_t i = 0; i < counts.front().count; ++i) {
            mav::MissionRequestInt one{.seq = i, .target_system = 1, .target_component = 1};
            one.mission_type = list;
            send(one);
            run(0.1);
        }
        return heard<mav::MissionItemInt>();
    }
};

TEST_F(MissionTransferTest, SeveralItemsCanBeAskedForAtOnce) {
    ASSERT_EQ(upload(12), static_cast<int>(result::kAccepted));
    forget();
    for (unsigned round = 0; round < 2; ++round) {  // what is asked twice before it comes is one
        for (uint16_t i = 0; i < 3; ++i) {
            send(mav::MissionRequestInt{.seq = i, .target_system = 1, .target_component = 1});
        }
    }
    run(0.3);
    const auto items = heard<mav::MissionItemInt>();
    ASSERT_EQ(items.size(), 3U);
    for (uint16_t i = 0; i < 3; ++i) EXPECT_EQ(items[i].seq, i);
}

TEST_F(MissionTransferTest, GoesThereAndBack) {
    for (uint8_t list = 0; list < 3; ++list) {
        ASSERT_EQ(upload(12, list), static_cast<int>(result::kAccepted));
        EXPECT_EQ(acks().front().opaque_id, ids_);
        EXPECT_NE(acks().front().opaque_id, 0U);
        const auto items = download(list);
        ASSERT_EQ(items.size(), 12U);
        for (uint16_t i = 0; i < 12; ++i) {
            auto expected = item(i, list);
            expected.target_system = kGround.system;
            expected.target_component = kGround.component;
            EXPECT_EQ(items[i].x, expected.x);
            EXPECT_EQ(items[i].command, expected.command);
            EXPECT_EQ(items[i].seq, i);
            EXPECT_EQ(items[i].mission_type, list);
            EXPECT_EQ(items[i].target_system, kGround.system);
        }
        EXPECT_EQ(heard<mav::MissionCount>().front().opaque_id, ids_);
    }
}

TEST_F(MissionTransferTest, OldStationsGetFloats) {
    ASSERT_EQ(upload(2), static_cast<int>(result::kAccepted));
    send(mav::MissionRequest{.seq = 1, .target_system = 1, .target_component = 1});
    run(0.1);
    ASSERT_EQ(heard<mav::MissionItem>().size(), 1U);
    EXPECT_NEAR(heard<mav::MissionItem>().front().x, 47.4F, 1e-4F);
}

TEST_F(MissionTransferTest, AnItemThatIsLostIsAskedForAgain) {
    ASSERT_EQ(upload(5, 0, 40), static_cast<int>(result::kAccepted));
    EXPECT_GT(heard<mav::MissionRequestInt>().size(), 5U);
    EXPECT_EQ(lists_[0].size(), 5U);
}

// The device takes parts each 100 ms, from a queue of 8.
TEST_F(MissionTransferTest, AStationThatAnswersAtOnceOrUnaskedDoesNotFloodTheDevice) {
    send_count(40);
    unsigned most = 0;
    std::size_t before = 0;
    for (unsigned i = 0; i < 300 && acks().empty(); ++i) {
        step();
        const auto asked = heard<mav::MissionRequestInt>();
        const auto unasked = static_cast<uint16_t>(new_items_.size());
        const bool is_answer = i % 3 != 0 && !asked.empty();
        send(item(is_answer ? asked.back().seq : unasked));
        if (i % 10 != 0) continue;
        most = std::max(most, static_cast<unsigned>(new_items_.size() - before));
        before = new_items_.size();
    }
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(acks().front().type, static_cast<int>(result::kAccepted));
    EXPECT_EQ(lists_[0].size(), 40U);
    EXPECT_LE(most, 6U);  // with the begin and the commit 8
}

TEST_F(MissionTransferTest, AnUploadThatStopsChangesNothing) {
    ASSERT_EQ(upload(3), static_cast<int>(result::kAccepted));
    const uint32_t id = mission_.mission_id;
    forget();
    send_count(4);
    run(0.1);
    send(item(0));
    run(6.0);
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(acks().front().type, result::kOperationCancelled);
    EXPECT_EQ(mission_.mission_id, id);
    EXPECT_EQ(upload(2), static_cast<int>(result::kAccepted));  // the next try works
}

// An acknowledgement may be lost: a station that sends its last item again has not heard it.
TEST_F(MissionTransferTest, HowAnUploadEndedIsToldAgain) {
    ASSERT_EQ(upload(3), static_cast<int>(result::kAccepted));
    const auto first = acks().front();
    forget();
    send(item(2), 0, {255, 1});  // another station
    send(item(3));               // there was none
    send(item(2, 1));            // of another list
    run(0.1);
    EXPECT_TRUE(acks().empty());
    send(item(2));
    run(0.1);
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(acks().front().type, result::kAccepted);
    EXPECT_EQ(acks().front().opaque_id, first.opaque_id);
    EXPECT_EQ(lists_[0].size(), 3U);
}

TEST_F(MissionTransferTest, ItemsOutOfOrderAreNotTaken) {
    send_count(3);
    run(0.05);
    send(item(2));
    send(item(1));
    run(0.05);
    EXPECT_TRUE(acks().empty());
    for (uint16_t i = 0; i < 3; ++i) {
        send(item(i));
        run(0.05);
    }
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(lists_[0].size(), 3U);
}

TEST_F(MissionTransferTest, ACountThatIsRepeatedAtOnceIsOne) {
    send_count(3);
    send_count(3);
    run(0.05);
    EXPECT_EQ(heard<mav::MissionRequestInt>().size(), 1U);
}

TEST_F(MissionTransferTest, AnotherStationWaits) {
    send_count(3);
    run(0.05);
    send_count(2, 0, {77, 1});
    run(0.05);
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(acks().front().type, result::kDenied);
    EXPECT_EQ(acks().front().target_system, 77);
}

TEST_F(MissionTransferTest, WhatCannotBeFlownIsRefusedWithItsReason) {
    struct Row {
        uint8_t list;
        mav::MissionItemInt item;
        uint32_t result;
    };
    auto camera = item(0);
    camera.command = 530;
    auto frame = item(0);
    frame.frame = mav::mav_frame::kLocalEnu;
    auto north = item(0);
    north.x = 910'000'000;
    auto east = item(0);
    east.y = -1'810'000'000;
    auto high = item(0);
    high.z = 1e9F;
    auto fence = item(0, 1);
    fence.command = 16;
    for (const Row& row :
         {Row{0, camera, result::kUnsupported}, Row{0, frame, result::kUnsupportedFrame},
          Row{0, north, result::kInvalidParam5X}, Row{0, east, result::kInvalidParam6Y},
          Row{0, high, result::kInvalidParam7}, Row{1, fence, result::kUnsupported}}) {
        forget();
        send_count(1, row.list);
        run(0.05);
        send(row.item);
        run(0.05);
        ASSERT_EQ(acks().size(), 1U);
        EXPECT_EQ(acks().front().type, row.result);
        EXPECT_EQ(heard<mav::Statustext>().size(), 1U);
    }
    EXPECT_EQ(mission_.count, 0);
}

TEST_F(MissionTransferTest, TooManyItemsHaveNoSpace) {
    send_count(129, 1);
    run(0.05);
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(acks().front().type, result::kNoSpace);
}

TEST_F(MissionTransferTest, ADeviceThatRefusesIsAnError) {
    device_is_broken_ = true;
    EXPECT_EQ(upload(3), static_cast<int>(result::kError));
}

TEST_F(MissionTransferTest, ClearsOneListOrAll) {
    for (uint8_t list = 0; list < 3; ++list) ASSERT_EQ(upload(2, list), 0);
    forget();
    mav::MissionClearAll one{.target_system = 1, .target_component = 1};
    one.mission_type = 1;
    send(one);
    run(0.1);
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(mission_.geofence_count, 0);
    EXPECT_EQ(mission_.count, 2);
    one.mission_type = 255;
    send(one);
    run(0.2);
    ASSERT_EQ(acks().size(), 2U);
    EXPECT_EQ(acks().back().mission_type, 255);
    EXPECT_EQ(acks().back().type, result::kAccepted);
    EXPECT_EQ(mission_.count + mission_.safe_points_count, 0);
}

TEST_F(MissionTransferTest, AnItemThatIsNotThereIsAnInvalidSequence) {
    send(mav::MissionRequestInt{.seq = 1000, .target_system = 1, .target_component = 1});
    run(0.1);
    ASSERT_EQ(acks().size(), 1U);
    EXPECT_EQ(acks().front().type, result::kInvalidSequence);
}

TEST_F(MissionTransferTest, TellsItemsAsTheyAreReachedAndTheEnd) {
    ASSERT_EQ(upload(3), 0);
    run(0.1);
    EXPECT_EQ(heard<mav::MissionCurrent>().back().mission_state, mav::mission_state::kNotStarted);
    status_ = {.arming_state = VehicleStatus::ArmingState::kArmed, .nav_state = Nav::kMission};
    result_.nav_state = static_cast<uint8_t>(Nav::kMission);
    for (int i = 0; i < 3; ++i) {
        result_.seq_reached = i;
        result_.seq_current = static_cast<uint16_t>(std::min(i + 1, 2));
        run(0.05);
    }
    const auto reached = heard<mav::MissionItemReached>();
    ASSERT_EQ(reached.size(), 3U);
    EXPECT_EQ(reached[1].seq, 1);
    EXPECT_EQ(heard<mav::MissionCurrent>().back().mission_state, mav::mission_state::kActive);
    EXPECT_EQ(heard<mav::MissionCurrent>().back().total, 3);
    result_.finished = true;
    run(0.03);
    status_.nav_state = Nav::kReturn;
    result_.finished = false;
    result_.nav_state = static_cast<uint8_t>(Nav::kReturn);
    run(0.1);
    EXPECT_EQ(heard<mav::MissionCurrent>().back().mission_state, mav::mission_state::kComplete);
}

}  // namespace
}  // namespace stator::apps::mavlink
