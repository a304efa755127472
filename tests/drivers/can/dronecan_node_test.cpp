// The vehicle as a node of a CAN bus, called with frames.
#include "dronecan_node.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <optional>
#include <vector>

#include "frames.hpp"
#include "stator/testing.hpp"

namespace stator::apps::dronecan_node {
namespace {

// Runs the node every 2 ms, with one frame more each time, and collects what it sends.
struct NodeTest : ::testing::Test {
    void run(const std::vector<CanFrame>& frames, unsigned more = 0) {
        for (unsigned i = 0; i < frames.size() + more; ++i) {
            now_us += 2000;
            VehicleStatus status{.arming_state = armed ? VehicleStatus::ArmingState::kArmed
                                                       : VehicleStatus::ArmingState::kDisarmed};
            DronecanNodePorts ports{
                .now = now_us,
                .can = i < frames.size() ? Input(frames[i]) : Input<CanFrame>(),
                .status = Input(status),
                .stored = next_record < stored.size() ? Input(stored[next_record])
                                                      : Input<StoredRecord>(),
                .memory = has_memory ? Input(memory) : Input<NonvolatileStatus>(),
                .parameter = answer.tag != 0 ? Input(answer) : Input<ParameterValue>(),
                .params = Input(params, is_first)};
            is_first = false;
            stator::testing::Probe sent(ports.frames, now_us);
            std::optional<stator::testing::Probe<RestartRequest>> restart;
            if (can_restart) restart.emplace(ports.restart, now_us);
            stator::testing::Probe request(ports.request, now_us);
            std::optional<stator::testing::Probe<StoredRecord>> store;
            if (has_memory) store.emplace(ports.store, now_us);
            stator::testing::Probe conflict(ports.conflict, now_us);
            stator::testing::Probe given(ports.allocation, now_us);
            node.step(ports);
            ++next_record;
            if (store && store->count() != 0) kept = store->newest();
            stores += store ? store->count() : 0;
            conflicts += conflict.count();
            if (conflict.count() != 0) newest_conflict = conflict.newest();
            if (given.count() != 0) allocated = given.newest();
            answer.tag = 0;
            sent_count += sent.count();
            if (restart) restarts += restart->count();
            requests += request.count();
            if (request.count() != 0) asked = request.newest();
            if (sent.count() != 0) newest = sent.newest();
        }
    }

    DronecanNode node;
    DronecanNodeParams params{.node_id = kOwnId,
                              .serial_number = 1,
                              .first_node = 1,
                              .last_node = 127,
                              .tool = 127,
                              .first_given = 50,
                              .last_given = 125};
    bool armed = false;
    bool has_memory = false;
    bool can_restart = true;
    NonvolatileStatus memory{.state = NonvolatileStatus::State::kLoading};
    std::vector<StoredRecord> stored;  // one in each activation
    std::size_t next_record = 0;
    StoredRecord kept{};
    bool is_first = true;
    uint64_t now_us = 1'000'000;
    uint32_t sent_count = 0;
    uint32_t restarts = 0;
    uint32_t requests = 0;
    uint32_t stores = 0;
    uint32_t conflicts = 0;
    CanNodeConflict newest_conflict{};
    CanAllocation allocated{};
    ParameterRequest asked{};
    ParameterValue answer{};  // to be read in the next activation; its tag 0: none
    CanFrame newest{};
};

TEST_F(NodeTest, says_how_it_is_once_a_second) {
    run({}, 1);
    EXPECT_EQ(sent_count, 1U);
    EXPECT_EQ(decoded<dronecan::protocol::NodeStatus>(newest).uptime_sec, 1U);
    run({}, 499);
    EXPECT_EQ(sent_count, 1U);
    run({}, 1);
    EXPECT_EQ(sent_count, 2U);
}

TEST_F(NodeTest, a_long_answer_goes_out_four_frames_at_a_time) {
    run({}, 1);
    run(frames_of(dronecan::protocol::GetNodeInfo::Request{}, 99, now_us));
    EXPECT_EQ(sent_count, 1U + 4U);
    run({}, 10);
    // 7 + 15 + 19 bytes of status and versions, 18 of the name, 2 of the checksum: 9 frames.
    EXPECT_EQ(sent_count, 1U + 9U);
}

TEST_F(NodeTest, a_restart_that_nobody_is_there_to_do_is_refused) {
    can_restart = false;
    using Restart = dronecan::protocol::RestartNode;
    run(frames_of(Restart::Request{.magic_number = Restart::Request::kMagicNumber}, 127, now_us),
        1);
    EXPECT_FALSE(decoded<Restart::Response>(newest).ok);
}

TEST_F(NodeTest, no_answer_is_more_urgent_than_motor_commands) {
    auto frames = frames_of(dronecan::protocol::GetNodeInfo::Request{}, 99, now_us);
    frames[0].id &= ~(0x1FU << 24);  // as urgent as a request can be
    run({}, 1);
    run(frames);
    EXPECT_EQ(dronecan::from_id(newest.id).priority, 16);
    run({}, 10);
    frames = frames_of(dronecan::protocol::GetNodeInfo::Request{}, 99, now_us, 1);
    frames[0].id |= 0x1FU << 24;
    run(frames);
    EXPECT_EQ(dronecan::from_id(newest.id).priority, 31) << "less urgent ones as they were asked";
}

TEST_F(NodeTest, asks_for_a_parameter_and_hands_the_answer_on_under_the_requests_transfer_id) {
    using dronecan::protocol::param::GetSet;
    run({}, 1);  // the status
    run(frames_of(GetSet::Request{.index = 2}, 99, now_us, 21), 5);
    EXPECT_EQ(requests, 1U);
    EXPECT_EQ(asked.index, 2);
    EXPECT_EQ(sent_count, 1U) << "not before it knows";
    run(frames_of(GetSet::Request{.index = 3}, 98, now_us), 1);
    EXPECT_EQ(requests, 1U) << "one at a time";
    answer = {.requester = ParameterValue::Requester::kCan,
              .tag = static_cast<uint8_t>(asked.tag + 1),
              .name = {'a'}};
    run({}, 1);
    EXPECT_EQ(sent_count, 1U) << "it is another request's";
    answer.tag = asked.tag;
    answer.requester = ParameterValue::Requester::kNone;
    run({}, 1);
    EXPECT_EQ(sent_count, 1U) << "it is another requester's";
    answer.tag = asked.tag;
    answer.requester = ParameterValue::Requester::kCan;
    run({}, 10);
    EXPECT_GT(sent_count, 1U);
    EXPECT_EQ(dronecan::from_id(newest.id).destination, 99);
    EXPECT_EQ(newest.data[newest.length - 1U] % dronecan::kTransferIds, 21);
    const uint32_t sent = sent_count;
    answer.tag = asked.tag;
    run({}, 10);
    EXPECT_EQ(sent_count, sent) << "an answer counts once";
}

TEST_F(NodeTest, a_parameter_that_nobody_answers_for_does_not_block_the_next) {
    using dronecan::protocol::param::GetSet;
    run(frames_of(GetSet::Request{}, 99, now_us), 251);  // half a second
    run(frames_of(GetSet::Request{}, 99, now_us, 1), 1);
    EXPECT_EQ(requests, 2U);
}

TEST_F(NodeTest, writes_parameters_for_the_tool_and_disarmed_only) {
    using dronecan::protocol::param::GetSet;
    using dronecan::protocol::param::Value;
    const GetSet::Request request{.value = {.tag = Value::Tag::kIntegerValue, .integer_value = 1}};
    const auto action = [&](uint8_t source, uint8_t transfer_id) {
        run(frames_of(request, source, now_us, transfer_id), 300);
        return asked.action;
    };
    EXPECT_EQ(action(99, 0), ParameterRequest::Action::kGet);
    EXPECT_EQ(action(127, 0), ParameterRequest::Action::kSet);
    armed = true;
    EXPECT_EQ(action(127, 1), ParameterRequest::Action::kGet);
    EXPECT_EQ(requests, 3U);
}

TEST_F(NodeTest, restarts_for_the_tool_and_disarmed_only) {
    using Restart = dronecan::protocol::RestartNode;
    const Restart::Request request{.magic_number = Restart::Request::kMagicNumber};
    run(frames_of(request, 99, now_us), 1);
    EXPECT_EQ(restarts, 0U);
    armed = true;
    run(frames_of(request, 127, now_us, 1), 1);
    EXPECT_EQ(restarts, 0U);
    armed = false;
    run(frames_of(Restart::Request{.magic_number = 1}, 127, now_us, 2), 1);
    EXPECT_EQ(restarts, 0U);
    run(frames_of(request, 127, now_us, 3), 1);
    EXPECT_EQ(restarts, 1U);
    EXPECT_TRUE(decoded<Restart::Response>(newest).ok);
}

// A graph with a memory for records.
struct MemoryTest : NodeTest {
    using Allocation = Allocator::Message;
    using State = NonvolatileStatus::State;

    // The bus has been heard for the time in which all nodes speak.
    explicit MemoryTest(bool has_listened = true) {
        has_memory = true;
        if (has_listened) run({CanFrame{.timestamp = now_us, .extended = true}}, 500);
        next_record = 0;
    }

    static Allocator::UniqueId part(uint8_t seed) {
        Allocator::UniqueId id;
        std::iota(id.begin(), id.end(), seed);
        return id;
    }
    static StoredRecord record_of(uint8_t node, uint8_t seed) {
        return {
            .key = node, .kind = StoredRecord::Kind::kCanNode, .length = 16, .data = part(seed)};
    }
    // The id that a part is given; 0: none. It is kept.
    uint32_t ask(uint8_t seed, uint8_t preferred = 0) {
        allocated = {};
        const auto unique_id = part(seed);
        for (unsigned first = 0; first < 16; first += 6) {
            Allocation request{.node_id = preferred, .first_part_of_unique_id = first == 0};
            request.unique_id.assign(std::span(unique_id).subspan(first, first < 12 ? 6 : 4));
            run(frames_of(request, 0, now_us, transfer_id++ % 32U), 3);
        }
        if (allocated.node_id != 0) {
            EXPECT_EQ(allocated.unique_id, unique_id);
        }
        return allocated.node_id;
    }
    // A NodeStatus of another node.
    void hear(uint8_t source, uint32_t uptime_s) {
        const dronecan::protocol::NodeStatus status{.uptime_sec = uptime_s};
        run(frames_of(status, source, now_us, transfer_id++ % 32U), 1);
    }
    uint8_t health() {
        run({}, 500);
        sent_count = 0;
        while (sent_count == 0) run({}, 1);
        return decoded<dronecan::protocol::NodeStatus>(newest).health;
    }

    uint8_t transfer_id = 0;
};

TEST_F(MemoryTest, an_id_is_given_once_all_records_are_loaded) {
    EXPECT_EQ(ask(1), 0U);
    memory.state = State::kLoaded;
    EXPECT_NE(ask(1), 0U);
    EXPECT_EQ(health(), 0);
}

TEST_F(MemoryTest, a_part_gets_the_id_that_it_had_and_no_other_part_does) {
    // 77 is not where the first part's unique id points.
    stored = {record_of(90, 9), record_of(77, 1)};
    stored[0].kind = StoredRecord::Kind::kParameter;
    run({}, 2);
    memory.state = State::kLoaded;
    EXPECT_EQ(ask(1), 77U);
    EXPECT_NE(ask(2, 77), 77U);
    EXPECT_EQ(ask(3, 90), 90U) << "what is no id takes none";
}

TEST_F(MemoryTest, one_that_never_says_so_is_not_waited_for) {
    EXPECT_EQ(ask(1), 0U);
    now_us = 10'000'000;
    EXPECT_NE(ask(1), 0U);
    EXPECT_EQ(health(), 1) << "a warning";
}

TEST_F(MemoryTest, without_one_that_works_the_table_is_here_alone_and_that_is_told) {
    memory.state = State::kFailed;
    const auto id = ask(1);
    EXPECT_NE(id, 0U);
    EXPECT_EQ(ask(1), id);
    EXPECT_EQ(health(), 1);
}

TEST_F(MemoryTest, a_record_that_is_not_kept_is_told) {
    memory = {.refused = 1, .state = State::kLoaded};
    EXPECT_EQ(health(), 1);
}

TEST_F(MemoryTest, a_full_table_is_told) {
    memory.state = State::kLoaded;
    params.first_given = 50;
    params.last_given = 50;
    is_first = true;  // they are new
    EXPECT_EQ(ask(1), 50U);
    EXPECT_EQ(health(), 0);
    EXPECT_EQ(ask(2), 0U);
    EXPECT_EQ(health(), 1);
}

struct SilentBus : MemoryTest {
    SilentBus() : MemoryTest(false) {}
};

TEST_F(SilentBus, no_id_is_given_before_every_node_had_time_to_speak) {
    memory.state = State::kLoaded;
    EXPECT_EQ(ask(1), 0U);
    hear(60, 0);
    run({}, 500);
    EXPECT_NE(ask(1, 60), 60U) << "which is taken";
    EXPECT_NE(allocated.node_id, 0);
}

TEST_F(MemoryTest, a_part_whose_id_another_node_uses_gets_another_and_that_is_told) {
    memory.state = State::kLoaded;
    const auto given = static_cast<uint8_t>(ask(1));
    ASSERT_NE(given, 0);
    hear(given, 5);
    EXPECT_EQ(ask(1), 0U) << "not yet clear whose it is";
    hear(given, 6);
    stores = 0;
    const uint32_t other = ask(1);
    EXPECT_NE(other, 0U);
    EXPECT_NE(other, given);
    EXPECT_EQ(conflicts, 1U);
    EXPECT_EQ(newest_conflict.kind, CanNodeConflict::Kind::kPart);
    EXPECT_EQ(newest_conflict.node_id, given);
    EXPECT_EQ(newest_conflict.new_node_id, other);
    EXPECT_EQ(newest_conflict.unique_id, part(1));
    EXPECT_EQ(health(), 1) << "a warning";
    // The memory knows both: whose the new one is, and that the old one is nobody's.
    EXPECT_EQ(stores, 2U);
    EXPECT_EQ(kept.key, given);
    EXPECT_EQ(kept.data, Allocator::UniqueId{});
}

TEST_F(MemoryTest, a_part_that_restarts_has_its_id_again_without_a_warning) {
    memory.state = State::kLoaded;
    const auto given = static_cast<uint8_t>(ask(1));
    hear(given, 0);
    hear(given, 1);
    EXPECT_EQ(ask(1), 0U);
    run({}, 1500);  // 3 s
    EXPECT_EQ(ask(1), given);
    hear(given, 0);
    EXPECT_EQ(conflicts, 0U);
    EXPECT_EQ(health(), 0);
}

TEST_F(MemoryTest, a_second_node_of_our_own_id_is_told_once) {
    memory.state = State::kLoaded;
    EXPECT_EQ(health(), 0);
    hear(kOwnId, 100);
    hear(kOwnId, 101);
    EXPECT_EQ(conflicts, 1U);
    EXPECT_EQ(newest_conflict.kind, CanNodeConflict::Kind::kOwn);
    EXPECT_EQ(newest_conflict.node_id, kOwnId);
    EXPECT_EQ(health(), 1);
}

TEST_F(MemoryTest, two_nodes_of_one_id_are_told_once_for_each_id) {
    memory.state = State::kLoaded;
    for (const uint8_t id : {uint8_t{60}, uint8_t{61}}) {
        for (uint32_t i = 0; i < 4; ++i) {
            hear(id, 1000 + i);
            hear(id, i);
        }
    }
    EXPECT_EQ(conflicts, 2U);
    EXPECT_EQ(newest_conflict.kind, CanNodeConflict::Kind::kShared);
    EXPECT_EQ(newest_conflict.node_id, 61);
    EXPECT_EQ(health(), 1);
}

}  // namespace
}  // namespace stator::apps::dronecan_node
