// The driver of the mission device: loads, tells, answers, takes uploads.
#include <gtest/gtest.h>

#include <optional>

#include "memory.hpp"
#include "stator/testing.hpp"

namespace stator::drivers::mission {
namespace {

Memory* memory = nullptr;

using Action = MissionUpload::Action;

struct Driver : ::testing::Test {
    Driver() {
        memory = &own;
        device.read = [](uint32_t address, std::span<uint8_t> bytes) {
            return memory->get(address, bytes);
        };
        device.write = [](uint32_t address, std::span<const uint8_t> bytes) {
            return memory->put(address, bytes);
        };
        driver.emplace(device);
    }
    void step(const MissionRequest* request = nullptr, const MissionUpload* part = nullptr) {
        MissionPorts ports{
            .now = 1000,
            .request = request == nullptr ? Input<MissionRequest>() : Input(*request),
            .upload = part == nullptr ? Input<MissionUpload>() : Input(*part)};
        stator::testing::Probe told(ports.mission, ports.now);
        stator::testing::Probe answered(ports.items, ports.now);
        driver->step(ports);
        was_told = told.count() != 0;
        was_answered = answered.count() != 0;
        if (was_told) mission = told.newest();
        if (was_answered) items = answered.newest();
    }
    void send(Action action, uint16_t first, uint16_t count, uint32_t id = 0) {
        MissionUpload part{.action = action,
                           .list = MissionUpload::List::kMission,
                           .first = first,
                           .count = count,
                           .id = id};
        part.command.fill(16);
        for (unsigned i = 0; i < part.x.size(); ++i) part.x[i] = static_cast<int32_t>(first + i);
        step(nullptr, &part);
    }
    void upload(uint16_t count) {
        send(Action::kBegin, 0, count);
        for (uint16_t i = 0; i < count; i = static_cast<uint16_t>(i + 4)) {
            send(Action::kItems, i, static_cast<uint16_t>(std::min(4, count - i)));
        }
    }

    Memory own;
    sim::MissionSim::Device device;
    std::optional<sim::MissionSim> driver;
    Mission mission{};
    MissionItems items{};
    bool was_told = false;
    bool was_answered = false;
};

TEST_F(Driver, tells_once_that_it_is_empty) {
    step();
    EXPECT_TRUE(was_told);
    EXPECT_EQ(mission.count, 0);
    step();
    EXPECT_FALSE(was_told);
}

TEST_F(Driver, a_board_without_a_memory_is_empty_after_some_tries) {
    device.read = nullptr;
    for (int i = 0; i < 5; ++i) step();
    EXPECT_TRUE(was_told);
    EXPECT_EQ(mission.count, 0);
}

TEST_F(Driver, an_upload_counts_with_its_commit) {
    step();
    upload(21);
    EXPECT_FALSE(was_told);
    EXPECT_EQ(mission.count, 0);
    send(Action::kCommit, 0, 0);
    EXPECT_TRUE(was_told);
    EXPECT_EQ(mission.count, 21);
    EXPECT_NE(mission.mission_id, 0U);
    EXPECT_EQ(mission.geofence_id, 0U);
    EXPECT_EQ(mission.refused, 0U);
}

TEST_F(Driver, a_part_out_of_order_is_refused_and_the_old_list_stays) {
    step();
    upload(4);
    send(Action::kCommit, 0, 0);
    const uint32_t id = mission.mission_id;
    send(Action::kBegin, 0, 8);
    send(Action::kItems, 4, 4);
    EXPECT_TRUE(was_told);
    EXPECT_EQ(mission.refused, 1U);
    send(Action::kCommit, 0, 0);
    EXPECT_EQ(mission.refused, 2U);
    EXPECT_EQ(mission.mission_id, id);
}

TEST_F(Driver, answers_with_a_window_of_the_list) {
    step();
    upload(21);
    send(Action::kCommit, 0, 0);
    MissionRequest request{.first = 0, .list = MissionRequest::List::kMission};
    step(&request);
    EXPECT_EQ(items.count, 16);
    EXPECT_EQ(items.id, mission.mission_id);
    request.first = 10;
    step(&request);
    EXPECT_EQ(items.count, 11);
    EXPECT_EQ(items.first, 10);
    EXPECT_EQ(items.x[10], 20);
    request.first = 30;
    step(&request);
    EXPECT_TRUE(was_answered);
    EXPECT_EQ(items.count, 0) << "there is none";
}

TEST_F(Driver, a_lost_memory_is_told_and_comes_back) {
    step();
    upload(4);
    send(Action::kCommit, 0, 0);
    device.put({.is_lost = true});
    step();
    EXPECT_TRUE(was_told);
    EXPECT_EQ(mission.count, 0);
    const MissionRequest request{.first = 0, .list = MissionRequest::List::kMission};
    step(&request);
    EXPECT_FALSE(was_answered);
    device.put({.is_lost = false});
    step();
    EXPECT_EQ(mission.count, 4);
}

TEST_F(Driver, reads_out_the_wanted_item_and_the_next) {
    while (!was_told) step();
    upload(5);
    send(Action::kCommit, 0, 0);
    const MissionRequest wanted{.first = 3, .list = MissionRequest::List::kMission};
    for (const uint16_t first : {uint16_t{3}, uint16_t{4}, uint16_t{5}}) {
        MissionRequest one = wanted;
        one.first = first;
        MissionPorts ports{.now = 1000, .download = Input(one)};
        stator::testing::Probe read(ports.downloaded, ports.now);
        driver->step(ports);
        EXPECT_EQ(read.count(), first == 3 ? 2U : 5U - first);
        if (first == 5) continue;
        EXPECT_EQ(read.newest().index, 4);
        EXPECT_EQ(read.newest().x, 4);
        EXPECT_EQ(read.newest().id, mission.mission_id);
    }
}

}  // namespace
}  // namespace stator::drivers::mission
