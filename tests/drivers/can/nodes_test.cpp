// The nodes that speak DroneCAN, each called with frames.
#include <gtest/gtest.h>

#include <initializer_list>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "can_esc.hpp"
#include "can_gnss.hpp"
#include "dronecan_node.hpp"
#include "get_set.hpp"
#include "stator/dronecan/crc.hpp"
#include "stator/dronecan/float16.hpp"
#include "stator/dronecan/port.hpp"
#include "stator/math/bits.hpp"
#include "stator/testing.hpp"

namespace stator {
namespace {

using dronecan::Frame;
using dronecan::equipment::esc::RawCommand;
using dronecan::equipment::esc::Status;
using dronecan::equipment::gnss::Auxiliary;
using dronecan::equipment::gnss::Fix2;

constexpr uint8_t kOwnId = 10;

template <class Message>
std::vector<CanFrame> frames_of(const Message& message, uint8_t source, uint64_t time_us,
                                uint8_t transfer_id = 0) {
    dronecan::Sender<Message::kType.most_bytes> sender;
    sender.begin({.source = source, .destination = kOwnId, .discriminator = 5}, transfer_id,
                 message);
    std::vector<CanFrame> frames;
    for (Frame frame; sender.next(frame);) {
        frames.push_back(dronecan::to_topic<CanFrame>(frame, time_us));
        frames.back().timestamp = time_us;
    }
    return frames;
}

template <class Message>
Message decoded(const CanFrame& single) {
    Message message;
    EXPECT_TRUE(dronecan::decode(std::span(single.data).first(single.length - 1U), message));
    return message;
}

// Replaces a field's 16 bits, which stand in whole bytes, and mends the checksum.
template <class Message>
void patch(std::vector<CanFrame>& frames, uint16_t from, uint16_t to) {
    std::vector<uint8_t*> payload;
    for (CanFrame& frame : frames) {
        for (unsigned i = 0; i + 1U < frame.length; ++i) payload.push_back(&frame.data[i]);
    }
    for (std::size_t i = 2; i + 1 < payload.size(); ++i) {
        if (*payload[i] != (from & 0xFF) || *payload[i + 1] != from >> 8) continue;
        *payload[i] = static_cast<uint8_t>(to);
        *payload[i + 1] = static_cast<uint8_t>(to >> 8);
        break;
    }
    uint16_t crc = Message::kType.crc_seed;
    for (std::size_t i = 2; i < payload.size(); ++i) crc = dronecan::crc16(crc, *payload[i]);
    *payload[0] = static_cast<uint8_t>(crc);
    *payload[1] = static_cast<uint8_t>(crc >> 8);
}

// --- can_esc ---

struct Esc : ::testing::Test {
    // One activation for each frame, and the newest report.
    void feed(const std::vector<CanFrame>& frames) {
        for (const CanFrame& frame : frames) step(&frame, nullptr);
    }
    void step(const CanFrame* frame, const ActuatorMotors* motors) {
        CanEscPorts ports{.now = now_us,
                          .motors = motors == nullptr ? Input<ActuatorMotors>() : Input(*motors),
                          .can = frame == nullptr ? Input<CanFrame>() : Input(*frame),
                          .params = Input(params, is_first)};
        is_first = false;
        stator::testing::Probe sent(ports.frames, now_us);
        stator::testing::Probe reported(ports.report, now_us);
        node.step(ports);
        commands += sent.count();
        if (sent.count() != 0) newest = sent.newest();
        if (reported.count() != 0) report = reported.newest();
    }
    EscStatus report_now() {
        now_us += 100'000;
        step(nullptr, nullptr);
        return report;
    }
    static Status status(uint8_t index) {
        return {.voltage = 12.0F, .temperature = 300.0F, .rpm = 5000, .esc_index = index};
    }

    CanEsc node;
    CanEscParams params{.node_id = kOwnId,
                        .esc_count = 4,
                        .command_interval = 2500,
                        .first_node = 20,
                        .last_node = 23,
                        .offline_timeout = 1.0F};
    bool is_first = true;
    uint64_t now_us = 1'000'000;
    uint32_t commands = 0;
    CanFrame newest{};
    EscStatus report{};
};

TEST_F(Esc, commands_go_out_and_a_stopped_motor_is_zero) {
    ActuatorMotors motors{.timestamp_sample = 7};
    motors.control.fill(math::canonical_nan<float>());
    motors.control[0] = 0.5F;
    motors.control[1] = 0.0F;  // turns, as slowly as it can
    motors.control[2] = 1.5F;
    step(nullptr, &motors);
    const auto command = decoded<RawCommand>(newest);
    ASSERT_EQ(command.cmd.count, 4);
    EXPECT_EQ(command.cmd.items[0], 4096);
    EXPECT_EQ(command.cmd.items[1], 1);
    EXPECT_EQ(command.cmd.items[2], 8191);
    EXPECT_EQ(command.cmd.items[3], 0);
    EXPECT_EQ(newest.timestamp_sample, 7U);
}

TEST_F(Esc, the_first_sample_of_each_interval_goes_out) {
    for (const uint64_t sample_us : {0, 1000, 2000, 3000, 4000, 5000, 6000, 7000, 8000, 10'000}) {
        ActuatorMotors motors{.timestamp = 1'000'000 + sample_us, .timestamp_sample = sample_us};
        step(nullptr, &motors);
        now_us += 1000;
    }
    EXPECT_EQ(commands, 5U) << "0, 3, 5, 8, 10 ms, as min_interval has it";
    EXPECT_EQ(newest.timestamp_sample, 10'000U);
}

TEST_F(Esc, without_commands_all_are_told_to_stop) {
    step(nullptr, nullptr);
    const auto command = decoded<RawCommand>(newest);
    ASSERT_EQ(command.cmd.count, 4);
    for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(command.cmd.items[i], 0);
    now_us += 5'000;
    step(nullptr, nullptr);
    EXPECT_EQ(commands, 1U) << "50 times a second is enough";
}

TEST_F(Esc, reports_are_collected_and_get_old) {
    feed(frames_of(status(2), 21, now_us));
    EscStatus now = report_now();
    EXPECT_EQ(now.esc_online_flags, 0b100);
    EXPECT_EQ(now.esc_rpm[2], 5000);
    EXPECT_EQ(now.esc_address[2], 21);
    EXPECT_NEAR(now.esc_temperature[2], 26.85F, 0.13F);  // binary16 has steps of 0.25 K there
    now_us += 1'000'000;
    now = report_now();
    EXPECT_EQ(now.esc_online_flags, 0);
    EXPECT_EQ(now.esc_rpm[2], 0);
}

TEST_F(Esc, a_controller_that_reports_after_a_late_release_is_online) {
    now_us += 100'000;  // of the release, which is served when the frames are there
    const auto frames = frames_of(status(1), 21, now_us + 300);
    feed({frames[0], frames[1]});
    now_us += 100'000;
    CanFrame last = frames[2];
    last.timestamp = now_us + 300;
    feed({last});
    EXPECT_EQ(report.esc_online_flags, 0b0010);
}

TEST_F(Esc, a_controller_speaks_for_itself_only) {
    feed(frames_of(status(1), 20, now_us));
    feed(frames_of(status(1), 21, now_us));
    EXPECT_EQ(report_now().esc_address[1], 20);
    EXPECT_EQ(report.rejected, 1U);
}

TEST_F(Esc, impossible_values_and_strangers_are_counted) {
    Status hot = status(0);
    hot.temperature = 5000.0F;
    Status none = status(0);
    none.voltage = math::canonical_nan<float>();
    feed(frames_of(hot, 20, now_us, 0));
    feed(frames_of(none, 20, now_us, 1));
    feed(frames_of(status(4), 20, now_us, 2));
    feed(frames_of(status(0), 24, now_us, 3));
    EXPECT_EQ(report_now().esc_online_flags, 0);
    EXPECT_EQ(report.rejected, 3U + 3U) << "three transfers, and the stranger's three frames";
}

TEST_F(Esc, no_field_takes_what_is_no_number_or_infinite) {
    using Field = float Status::*;
    uint8_t transfer_id = 0;
    for (const Field field : {&Status::voltage, &Status::current, &Status::temperature}) {
        // Infinite numbers are not sent; so as bits of a frame.
        for (const uint16_t bits : std::array<uint16_t, 3>{0x7C00, 0xFC00, 0x7E00}) {
            Status bad = status(0);
            bad.*field = 1.0F;
            auto frames = frames_of(bad, 20, now_us, transfer_id++);
            patch<Status>(frames, dronecan::to_float16(1.0F), bits);
            feed(frames);
        }
    }
    EXPECT_EQ(report_now().esc_online_flags, 0);
    EXPECT_EQ(report.rejected, 9U);
}

TEST_F(Esc, frames_that_are_none_of_the_protocol_count_for_nothing) {
    auto frames = frames_of(status(0), 20, now_us);
    for (CanFrame& frame : frames) frame.extended = false;
    feed(frames);
    EXPECT_EQ(report_now().rejected, 0U) << "11 bits are another protocol's";
    frames = frames_of(status(0), 20, now_us);
    for (CanFrame& frame : frames) frame.length = 64;
    feed(frames);
    EXPECT_EQ(report_now().rejected, 3U);
    EXPECT_EQ(report.esc_online_flags, 0);
}

// --- can_gnss ---

struct Gnss : ::testing::Test {
    uint32_t feed(const std::vector<CanFrame>& frames) {
        uint32_t count = 0;
        for (const CanFrame& frame : frames) {
            CanGnssPorts ports{
                .now = frame.timestamp, .can = Input(frame), .params = Input(params, is_first)};
            is_first = false;
            stator::testing::Probe position(ports.position, ports.now);
            node.step(ports);
            count += position.count();
            if (position.count() != 0) newest = position.newest();
        }
        return count;
    }
    static Fix2 fix() {
        return {.longitude_deg_1e8 = 854'559'400,
                .latitude_deg_1e8 = 4'739'774'200,
                .height_msl_mm = 488'000,
                .ned_velocity = {1.0F, 2.0F, 3.0F},
                .sats_used = 9,
                .status = Fix2::kStatus3dFix};
    }

    CanGnss node;
    CanGnssParams params{.first_node = 40, .last_node = 49, .latency = 0.1F, .range_error = 2.0F};
    bool is_first = true;
    SensorGps newest{};
};

TEST_F(Gnss, a_fix_becomes_a_position) {
    Fix2 message = fix();
    message.covariance.assign(std::array{4.0F, 4.0F, 9.0F, 0.25F, 0.25F, 0.25F});
    ASSERT_EQ(feed(frames_of(message, 40, 1'000'000)), 1U);
    EXPECT_EQ(newest.timestamp_sample, 900'000U);
    EXPECT_EQ(newest.latitude_deg, 47.397742);
    EXPECT_EQ(newest.longitude_deg, 8.545594);
    EXPECT_EQ(newest.altitude_msl_m, 488.0);
    EXPECT_EQ(newest.eph, 2.0F);
    EXPECT_EQ(newest.epv, 3.0F);
    EXPECT_EQ(newest.fix_type, SensorGps::FixType::kFix3d);
    EXPECT_EQ(newest.satellites_used, 9);
}

TEST_F(Gnss, without_covariance_the_geometry_tells_the_error) {
    feed(frames_of(Auxiliary{.hdop = 0.75F, .vdop = 1.5F}, 40, 1'000'000));
    ASSERT_EQ(feed(frames_of(fix(), 40, 1'000'000)), 1U);
    EXPECT_EQ(newest.eph, 1.5F);
    EXPECT_EQ(newest.epv, 3.0F);
    EXPECT_TRUE(math::is_nan(newest.s_variance_m_s));
}

TEST_F(Gnss, a_geometry_that_comes_in_the_middle_of_a_fix_counts_for_it) {
    std::vector<CanFrame> frames = frames_of(fix(), 40, 1'000'000);
    const auto last = frames.back();
    frames.pop_back();
    feed(frames);
    feed(frames_of(Auxiliary{.hdop = 0.75F, .vdop = 1.5F}, 40, 1'001'000));
    ASSERT_EQ(feed({last}), 1U);
    EXPECT_EQ(newest.eph, 1.5F);
}

TEST_F(Gnss, an_impossible_fix_is_dropped_and_the_next_one_taken) {
    Fix2 far = fix();
    far.latitude_deg_1e8 = 9'000'000'001;
    EXPECT_EQ(feed(frames_of(far, 40, 1'000'000, 0)), 0U);
    EXPECT_EQ(node.counters().undecodable, 1U);
    Fix2 wild = fix();
    wild.ned_velocity[1] = math::canonical_nan<float>();
    EXPECT_EQ(feed(frames_of(wild, 40, 1'200'000, 1)), 0U);
    EXPECT_EQ(feed(frames_of(fix(), 40, 1'400'000, 2)), 1U);
}

TEST_F(Gnss, each_field_has_its_bounds) {
    uint64_t now_us = 1'000'000;
    uint8_t transfer_id = 0;
    const auto takes = [&](auto change) {
        Fix2 changed = fix();
        change(changed);
        return feed(frames_of(changed, 40, now_us += 200'000, transfer_id++)) == 1;
    };
    EXPECT_TRUE(takes([](Fix2& f) { f.latitude_deg_1e8 = -9'000'000'000; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.latitude_deg_1e8 = -9'000'000'001; }));
    EXPECT_TRUE(takes([](Fix2& f) { f.longitude_deg_1e8 = 18'000'000'000; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.longitude_deg_1e8 = 18'000'000'001; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.longitude_deg_1e8 = -18'000'000'001; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.height_msl_mm = 60'000'001; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.height_msl_mm = -1'000'001; }));
    for (unsigned i = 0; i < 3; ++i) {
        EXPECT_FALSE(takes([&](Fix2& f) { f.ned_velocity[i] = 1000.5F; }));
        EXPECT_FALSE(takes([&](Fix2& f) { f.ned_velocity[i] = math::canonical_nan<float>(); }));
    }
    EXPECT_FALSE(takes([](Fix2& f) {
        f.covariance.assign(std::array{1.0F, 1.0F, 1.0F, 1.0F, math::canonical_nan<float>(), 1.0F});
    }));
    EXPECT_TRUE(takes([](Fix2& f) {
        f.covariance.assign(std::array{-1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F});
    }));
    EXPECT_TRUE(math::is_nan(newest.eph)) << "a variance below 0 tells nothing";
    EXPECT_FALSE(feed(frames_of(Auxiliary{.hdop = math::canonical_nan<float>()}, 40, now_us)));
    EXPECT_TRUE(takes([](Fix2&) {}));
    EXPECT_TRUE(math::is_nan(newest.eph)) << "and neither does a geometry that is no number";
}

TEST_F(Gnss, a_second_receiver_is_heard_once_the_first_is_silent) {
    EXPECT_EQ(feed(frames_of(fix(), 40, 1'000'000)), 1U);
    EXPECT_EQ(feed(frames_of(fix(), 41, 1'200'000)), 0U);
    EXPECT_EQ(feed(frames_of(fix(), 41, 4'300'000, 1)), 1U);
}

// --- dronecan_node ---

TEST(DronecanAllocator, gives_the_same_part_the_same_id_even_without_its_table) {
    using Message = Allocator::Message;
    const auto allocate = [](Allocator& allocator, uint8_t seed) {
        uint8_t node = 0;
        uint64_t now_us = 1'000'000;
        for (const auto& [first, count] : {std::pair{0, 6}, {6, 6}, {12, 4}}) {
            Message request{.first_part_of_unique_id = first == 0};
            request.unique_id.count = static_cast<uint16_t>(count);
            for (int i = 0; i < count; ++i) {
                request.unique_id.items[static_cast<unsigned>(i)] =
                    static_cast<uint8_t>(seed + first + i);
            }
            const auto answer = allocator.answer(request, now_us += 1000);
            if (answer) node = answer->node_id;
        }
        return node;
    };
    Allocator one;
    Allocator other;
    one.set_range(50, 125);
    other.set_range(50, 125);
    const uint8_t a = allocate(one, 1);
    const uint8_t b = allocate(one, 2);
    EXPECT_NE(a, 0);
    EXPECT_NE(b, 0);
    EXPECT_NE(a, b);
    EXPECT_EQ(allocate(one, 1), a);
    EXPECT_EQ(allocate(other, 2), b);

    Allocator full;
    full.set_range(50, 51);
    full.note_taken(50);
    EXPECT_EQ(allocate(full, 1), 51);
    EXPECT_FALSE(full.is_full());
    EXPECT_EQ(allocate(full, 2), 0) << "no id is left";
    EXPECT_TRUE(full.is_full());
    EXPECT_EQ(allocate(full, 1), 51) << "which is its own";
}

TEST(DronecanAllocator, remembers_only_what_can_be_an_id) {
    Allocator allocator;
    const Allocator::UniqueId part{1};
    allocator.remember(0, part);
    allocator.remember(128, part);
    allocator.remember(UINT32_MAX, part);
    allocator.remember(60, std::span(part).first(15));
}

TEST(DronecanAllocator, a_piece_that_comes_late_or_out_of_turn_is_no_continuation) {
    Allocator allocator;
    allocator.set_range(50, 125);
    Allocator::Message piece;
    piece.unique_id.count = 6;
    EXPECT_FALSE(allocator.answer(piece, 1000));
    piece.first_part_of_unique_id = true;
    EXPECT_TRUE(allocator.answer(piece, 2000));
    piece.first_part_of_unique_id = false;
    EXPECT_FALSE(allocator.answer(piece, 2000 + 500'001));
    piece.first_part_of_unique_id = true;
    EXPECT_TRUE(allocator.answer(piece, 600'000));
    piece.first_part_of_unique_id = false;
    piece.unique_id.count = 5;
    EXPECT_FALSE(allocator.answer(piece, 601'000));
}

namespace get_set {

using dronecan::protocol::param::GetSet;
using dronecan::protocol::param::NumericValue;
using dronecan::protocol::param::Value;

GetSet::Request write(const Value& value) {
    GetSet::Request request{.index = 3, .value = value};
    request.name.assign(std::string_view("wing.gain"));
    return request;
}

TEST(DronecanGetSet, a_value_is_written_by_who_may) {
    const Value half{.tag = Value::Tag::kRealValue, .real_value = 0.5F};
    ParameterRequest request = to_request(write(half), 9, true);
    EXPECT_EQ(request.requester, ParameterRequest::Requester::kCan);
    EXPECT_EQ(request.tag, 9);
    EXPECT_EQ(request.action, ParameterRequest::Action::kSet);
    EXPECT_EQ(request.type, ParameterRequest::Type::kFloat);
    EXPECT_EQ(request.float_value, 0.5F);
    EXPECT_EQ(request.index, 3);
    EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(request.name.data())), "wing.gain");
    request = to_request(write(half), 9, false);
    EXPECT_EQ(request.action, ParameterRequest::Action::kGet);
    EXPECT_EQ(to_request(write({}), 9, true).action, ParameterRequest::Action::kGet);
}

TEST(DronecanGetSet, what_fits_none_of_our_types_only_asks) {
    const auto whole = [](int64_t value) {
        return to_request(write({.tag = Value::Tag::kIntegerValue, .integer_value = value}), 1,
                          true);
    };
    EXPECT_EQ(whole(INT32_MIN).action, ParameterRequest::Action::kSet);
    EXPECT_EQ(whole(INT32_MIN).int_value, INT32_MIN);
    EXPECT_EQ(whole(int64_t{INT32_MAX} + 1).action, ParameterRequest::Action::kGet);
    EXPECT_EQ(to_request(write({.tag = Value::Tag::kStringValue}), 1, true).action,
              ParameterRequest::Action::kGet);
    EXPECT_EQ(
        to_request(write({.tag = Value::Tag::kBooleanValue, .boolean_value = 1}), 1, true).type,
        ParameterRequest::Type::kBool);
}

TEST(DronecanGetSet, an_answer_is_of_the_parameters_type) {
    ParameterValue value{.type = ParameterValue::Type::kInt32,
                         .int_value = -2,
                         .int_least = -5,
                         .int_most = 5,
                         .int_default = 1,
                         .name = {'a', '.', 'b'}};
    GetSet::Response response = to_response(value);
    EXPECT_EQ(response.value.tag, Value::Tag::kIntegerValue);
    EXPECT_EQ(response.value.integer_value, -2);
    EXPECT_EQ(response.default_value.integer_value, 1);
    EXPECT_EQ(response.min_value.integer_value, -5);
    EXPECT_EQ(response.max_value.integer_value, 5);
    EXPECT_EQ(response.name.count, 3);
    value.type = ParameterValue::Type::kFloat;
    value.float_most = 2.5F;
    EXPECT_EQ(to_response(value).max_value.real_value, 2.5F);
    value.type = ParameterValue::Type::kBool;
    EXPECT_EQ(to_response(value).value.tag, Value::Tag::kBooleanValue);
    EXPECT_EQ(to_response(value).max_value.tag, NumericValue::Tag::kEmpty);
    value.result = ParameterValue::Result::kUnknown;
    EXPECT_EQ(to_response(value).name.count, 0);
    EXPECT_EQ(to_response(value).value.tag, Value::Tag::kEmpty);
    value.result = ParameterValue::Result::kRead;
    value.name.fill('x');
    EXPECT_EQ(to_response(value).name.count, 92);
}

}  // namespace get_set

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
            node.step(ports);
            ++next_record;
            if (store && store->count() != 0) kept = store->newest();
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

    MemoryTest() { has_memory = true; }

    static Allocator::UniqueId part(uint8_t seed) {
        Allocator::UniqueId id;
        std::iota(id.begin(), id.end(), seed);
        return id;
    }
    static StoredRecord record_of(uint8_t node, uint8_t seed) {
        return {
            .key = node, .kind = StoredRecord::Kind::kCanNode, .length = 16, .data = part(seed)};
    }
    // The id that a part is given and that is kept; 0: none.
    uint32_t ask(uint8_t seed, uint8_t preferred = 0) {
        kept = {};
        const auto unique_id = part(seed);
        for (unsigned first = 0; first < 16; first += 6) {
            Allocation request{.node_id = preferred, .first_part_of_unique_id = first == 0};
            request.unique_id.assign(std::span(unique_id).subspan(first, first < 12 ? 6 : 4));
            run(frames_of(request, 0, now_us, transfer_id++ % 32U), 3);
        }
        if (kept.key != 0) {
            EXPECT_EQ(kept.data, unique_id);
        }
        return kept.key;
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
    EXPECT_EQ(ask(1), 50U);
    EXPECT_EQ(health(), 0);
    EXPECT_EQ(ask(2), 0U);
    EXPECT_EQ(health(), 1);
}

}  // namespace
}  // namespace stator
