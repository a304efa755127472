// Parameters that outlive a restart: the node, a memory whose power fails, and new firmware whose
// table is another one. Topics and tables are made by hand.
#include "keeper.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "memory.hpp"
#include "parameters.hpp"
#include "stator/testing.hpp"

namespace stator::apps::parameters {
namespace {

using drivers::nonvolatile::Memory;
using drivers::nonvolatile::MemoryPort;
using drivers::nonvolatile::Store;
using Action = ParameterRequest::Action;
using Result = ParameterValue::Result;
using Type = ParameterRequest::Type;
using State = NonvolatileStatus::State;

struct WingParams {
    uint64_t timestamp{};
    float gain{};
    float limit{};
    int32_t count{};
    bool inverted{};
    uint8_t padding[3]{};
};

constexpr uint32_t kGain = 101;
constexpr uint32_t kLimit = 102;
constexpr uint32_t kCount = 103;
constexpr uint32_t kInverted = 104;
constexpr uint32_t kFloat = 1;  // definitions
constexpr uint32_t kMeters = 2;
constexpr uint32_t kWhole = 3;
constexpr uint32_t kFlag = 4;

std::vector<ParameterRow> usual_rows() {
    return {
        parameter::whole({"wing.count", "WING_COUNT", kCount, kWhole}, 0,
                         offsetof(WingParams, count), -3, 7, 4),
        parameter::real({"wing.gain", "WING_GAIN", kGain, kFloat}, 0, offsetof(WingParams, gain),
                        0.0F, 2.0F, 0.5F),
        parameter::flag({"wing.inverted", "WING_INVERTED", kInverted, kFlag}, 0,
                        offsetof(WingParams, inverted), false),
        parameter::real({"wing.limit", "WING_LIMIT", kLimit, kMeters}, 0,
                        offsetof(WingParams, limit), 0.0F, 100.0F, 10.0F),
    };
}

// One life of a vehicle, from its start to its end.
class Life {
  public:
    explicit Life(Memory& memory, std::vector<ParameterRow> rows = usual_rows(),
                  std::vector<FormerParameter> former = {}, uint8_t short_lives = 0)
        : rows_(std::move(rows)), former_(std::move(former)), store_(MemoryPort{&memory}) {
        status_.short_lives = short_lives;
        Output<WingParams> output;
        output.connect(topic_.topic(), 0, false);
        output.publish([] { return WingParams{.gain = 0.5F, .limit = 10.0F, .count = 4}; });
    }

    // 10 ms: the memory's node, then ours.
    void step(const ParameterRequest* request = nullptr) {
        now_us_ += 10'000;
        run_memory();
        do {
            activate(request);
            request = nullptr;
        } while (!told_.empty());
    }
    void run_for(unsigned steps) {
        for (unsigned i = 0; i < steps; ++i) step();
    }
    void start() { run_for(70); }

    Result set(const char* name, Type type, float real, int32_t whole = 0) {
        ParameterRequest request{
            .action = Action::kSet, .type = type, .float_value = real, .int_value = whole};
        std::memcpy(request.name.data(), name, std::strlen(name));
        step(&request);
        return value.result;
    }
    Result set_gain(float gain) { return set("wing.gain", Type::kFloat, gain); }

    const WingParams& params() const { return topic_.newest(); }
    uint32_t publications() const { return topic_.count(); }
    const Store& store() const { return store_; }

    ParameterStatus report{};
    ParameterValue value{};
    VehicleStatus vehicle{};
    bool has_memory = true;
    bool loses_records = false;  // between the nodes
    bool holds_back = false;     // of the memory: it does not load yet

  private:
    void run_memory() {
        StoredRecord record{};
        for (unsigned i = 0; i < 4 && !store_.is_loaded() && !holds_back; ++i) {
            const auto loaded = store_.load_next(record);
            if (loaded == Store::Load::kRecord) told_.push_back(record);
            if (loaded == Store::Load::kFailed && ++failures_ == 5) status_.state = State::kFailed;
        }
        if (store_.is_loaded()) status_.state = State::kLoaded;
        if (!wanted_) return;
        const auto result = store_.is_loaded() ? store_.keep(*wanted_) : Store::Keep::kFailed;
        kept_ = {.key = wanted_->key,
                 .kind = RecordKept::Kind::kParameter,
                 .result = static_cast<RecordKept::Result>(result)};
        wanted_.reset();
    }

    void activate(const ParameterRequest* request) {
        const std::optional<RecordKept> kept = std::exchange(kept_, {});
        std::optional<StoredRecord> told;
        if (!told_.empty()) {
            told = told_.front();
            told_.pop_front();
        }
        ParametersPorts ports{
            .now = now_us_,
            .request = request == nullptr ? Input<ParameterRequest>() : Input(*request),
            .status = Input(vehicle),
            .stored = told ? Input(*told) : Input<StoredRecord>(),
            .memory = has_memory ? Input(status_) : Input<NonvolatileStatus>(),
            .kept = kept ? Input(*kept) : Input<RecordKept>()};
        ports.parameters.connect(table_, now_us_);
        stator::testing::Probe answered(ports.value, now_us_);
        stator::testing::Probe to_store(ports.store, now_us_);
        stator::testing::Probe reported(ports.report, now_us_);
        node_.step(ports);
        if (answered.count() != 0) value = answered.newest();
        if (reported.count() != 0) report = reported.newest();
        EXPECT_LE(to_store.count(), 1U) << "one at a time";
        if (to_store.count() != 0) {
            EXPECT_FALSE(wanted_.has_value()) << "the one before has its result";
            if (!loses_records) wanted_ = to_store.newest();
        }
    }

    std::vector<ParameterRow> rows_;
    std::vector<FormerParameter> former_;
    Store store_;
    NonvolatileStatus status_{};
    std::deque<StoredRecord> told_;
    std::optional<StoredRecord> wanted_;
    std::optional<RecordKept> kept_;
    unsigned failures_ = 0;
    uint64_t now_us_ = 0;
    stator::testing::LoneTopic<WingParams> topic_;
    ParameterTopic topics_[1]{{&topic_.topic(), true}};
    ParameterTable table_{.rows = rows_.data(),
                          .row_count = static_cast<uint32_t>(rows_.size()),
                          .former = former_.data(),
                          .former_count = static_cast<uint32_t>(former_.size()),
                          .topics = topics_,
                          .topic_count = 1};
    Parameters node_;
};

void keep_some(Memory& memory) {
    Life life(memory);
    life.start();
    EXPECT_EQ(life.set_gain(1.5F), Result::kWritten);
    EXPECT_EQ(life.set("WING_COUNT", Type::kInt32, 0.0F, -2), Result::kWritten);
    EXPECT_EQ(life.set("wing.inverted", Type::kBool, 0.0F, 1), Result::kWritten);
    life.run_for(10);
    EXPECT_EQ(life.report.pending, 0);
    EXPECT_EQ(life.report.stored, 3);
}

TEST(Keeper, what_was_set_counts_after_a_restart) {
    Memory memory;
    keep_some(memory);
    Life life(memory);
    life.start();
    EXPECT_EQ(life.params().gain, 1.5F);
    EXPECT_EQ(life.params().count, -2);
    EXPECT_TRUE(life.params().inverted);
    EXPECT_EQ(life.params().limit, 10.0F);
    EXPECT_EQ(life.report.stored, 3);
    EXPECT_EQ(life.report.count, 4);
    EXPECT_EQ(life.report.state, ParameterStatus::State::kLoaded);
}

TEST(Keeper, only_what_differs_from_the_graph_is_kept) {
    Memory memory;
    keep_some(memory);
    {
        Life life(memory);
        life.start();
        life.set_gain(0.5F);
        life.set("wing.limit", Type::kFloat, 10.0F);
        life.run_for(10);
        EXPECT_EQ(life.report.stored, 2);
        EXPECT_EQ(life.store().records(), 2U);
    }
    Life life(memory);
    life.start();
    EXPECT_EQ(life.params().gain, 0.5F);
    EXPECT_EQ(life.report.stored, 2);
}

TEST(Keeper, a_start_without_records_publishes_nothing) {
    Memory memory;
    Life life(memory);
    life.start();
    EXPECT_EQ(life.publications(), 1U);
    EXPECT_EQ(memory.written, 0U);
}

TEST(Keeper, without_a_memory_changes_count_until_the_restart) {
    Memory memory;
    Life life(memory);
    life.has_memory = false;
    EXPECT_EQ(life.set_gain(1.0F), Result::kWritten);
    life.run_for(10);
    EXPECT_EQ(life.params().gain, 1.0F);
    EXPECT_EQ(life.report.pending, 0);
    EXPECT_EQ(life.report.state, ParameterStatus::State::kNone);
    EXPECT_EQ(memory.written, 0U);
}

TEST(Keeper, a_change_while_records_are_loaded_wins) {
    Memory memory;
    keep_some(memory);
    Life life(memory);
    life.holds_back = true;
    life.step();
    EXPECT_EQ(life.set_gain(0.75F), Result::kWritten);
    life.holds_back = false;
    life.start();
    EXPECT_EQ(life.params().gain, 0.75F);
    EXPECT_EQ(life.params().count, -2);
    Life next(memory);
    next.start();
    EXPECT_EQ(next.params().gain, 0.75F);
}

TEST(Keeper, armed_it_refuses_what_changes_on_the_ground_only) {
    Memory memory;
    std::vector<ParameterRow> rows = usual_rows();
    rows[0] = parameter::on_ground(rows[0]);
    Life life(memory, rows);
    life.start();
    life.vehicle.arming_state = VehicleStatus::ArmingState::kArmed;
    EXPECT_EQ(life.set("wing.count", Type::kInt32, 0.0F, 1), Result::kArmed);
    EXPECT_EQ(life.value.int_value, 4) << "what counts is told";
    EXPECT_TRUE(life.value.on_ground);
    EXPECT_EQ(life.set_gain(1.0F), Result::kWritten);
    life.vehicle.arming_state = VehicleStatus::ArmingState::kDisarmed;
    EXPECT_EQ(life.set("wing.count", Type::kInt32, 0.0F, 1), Result::kWritten);
}

// --- other firmware ---

TEST(Keeper, a_value_of_another_unit_does_not_count_and_stays) {
    Memory memory;
    keep_some(memory);
    std::vector<ParameterRow> rows = usual_rows();
    rows[1].is.definition = kMeters;
    {
        Life life(memory, rows);
        life.start();
        EXPECT_EQ(life.params().gain, 0.5F);
        EXPECT_EQ(life.params().count, -2) << "the others do";
        EXPECT_EQ(life.report.redefined, 1);
        EXPECT_EQ(life.report.unused[0], 2) << "which one, from 1";
        EXPECT_EQ(life.report.unused[1], 0);
    }
    Life back(memory);
    back.start();
    EXPECT_EQ(back.params().gain, 1.5F) << "after a downgrade";
}

TEST(Keeper, a_new_value_replaces_one_of_another_unit) {
    Memory memory;
    keep_some(memory);
    std::vector<ParameterRow> rows = usual_rows();
    rows[1].is.definition = kMeters;
    for (const float gain : {0.25F, 0.5F}) {  // the second one is the default
        Life life(memory, rows);
        life.start();
        life.set_gain(gain);
        life.run_for(10);
        Life next(memory, rows);
        next.start();
        EXPECT_EQ(next.params().gain, gain);
        EXPECT_EQ(next.report.redefined, 0);
    }
}

TEST(Keeper, a_value_outside_a_new_range_does_not_count_and_one_inside_does) {
    Memory memory;
    keep_some(memory);
    std::vector<ParameterRow> rows = usual_rows();
    rows[1].most = std::bit_cast<ParameterBits>(1.0F);
    rows[0].least = std::bit_cast<ParameterBits>(int32_t{-2});
    Life life(memory, rows);
    life.start();
    EXPECT_EQ(life.params().gain, 0.5F);
    EXPECT_EQ(life.report.out_of_range, 1);
    EXPECT_EQ(life.params().count, -2);
}

TEST(Keeper, a_parameter_that_is_fixed_now_keeps_the_graphs_value) {
    Memory memory;
    keep_some(memory);
    std::vector<ParameterRow> rows = usual_rows();
    rows[1] = parameter::fixed(rows[1]);
    Life life(memory, rows);
    life.start();
    EXPECT_EQ(life.params().gain, 0.5F);
    EXPECT_EQ(life.report.redefined, 1);
}

TEST(Keeper, a_new_default_does_not_replace_a_kept_value) {
    Memory memory;
    keep_some(memory);
    std::vector<ParameterRow> rows = usual_rows();
    rows[1].standard = std::bit_cast<ParameterBits>(0.8F);
    Life life(memory, rows);
    life.start();
    EXPECT_EQ(life.params().gain, 1.5F);
}

TEST(Keeper, an_unknown_record_stays_and_is_counted) {
    Memory memory;
    keep_some(memory);
    std::vector<ParameterRow> rows = usual_rows();
    rows.erase(rows.begin() + 1);
    {
        Life life(memory, rows);
        life.start();
        EXPECT_EQ(life.report.unknown, 1);
        EXPECT_EQ(life.report.stored, 2);
        EXPECT_EQ(life.store().records(), 3U);
    }
    Life back(memory);
    back.start();
    EXPECT_EQ(back.params().gain, 1.5F);
}

constexpr uint32_t kNewGain = 201;

std::vector<ParameterRow> renamed_rows() {
    std::vector<ParameterRow> rows = usual_rows();
    rows[1].is = {"wing.scale", "WING_SCALE", kNewGain, kFloat};
    return rows;
}

TEST(Keeper, a_renamed_parameter_keeps_its_value) {
    Memory memory;
    keep_some(memory);
    for (int start = 0; start < 3; ++start) {
        Life life(memory, renamed_rows(), {{kGain, 1}});
        life.start();
        life.run_for(10);
        EXPECT_EQ(life.params().gain, 1.5F) << start;
        EXPECT_EQ(life.report.stored, 3);
        EXPECT_EQ(life.report.unknown, 0);
        EXPECT_EQ(life.store().records(), 3U) << "the old record has gone";
    }
    Life life(memory, renamed_rows(), {{kGain, 1}});
    life.start();
    life.set("wing.scale", Type::kFloat, 0.5F);
    life.run_for(10);
    Life next(memory, renamed_rows(), {{kGain, 1}});
    next.start();
    EXPECT_EQ(next.params().gain, 0.5F) << "the old value does not come back";
}

TEST(Keeper, a_renamed_parameter_keeps_its_value_wherever_power_fails) {
    Memory kept;
    keep_some(kept);
    for (uint64_t cut = 0; cut <= 4 * 32; ++cut) {
        for (const bool spoils : {false, true}) {
            Memory memory = kept;
            memory.written = 0;
            memory.cut_after = cut;
            memory.spoils_last = spoils;
            {
                Life life(memory, renamed_rows(), {{kGain, 1}});
                life.start();
                life.run_for(10);
            }
            memory.cut_after = Memory::kNoCut;
            Life life(memory, renamed_rows(), {{kGain, 1}});
            life.start();
            EXPECT_EQ(life.params().gain, 1.5F) << cut;
            EXPECT_EQ(life.params().count, -2) << cut;
        }
    }
}

TEST(Keeper, a_change_wins_over_a_value_under_the_old_name) {
    Memory memory;
    keep_some(memory);
    Life life(memory, renamed_rows(), {{kGain, 1}});
    life.holds_back = true;
    life.set("wing.scale", Type::kFloat, 0.25F);
    life.holds_back = false;
    life.start();
    life.run_for(10);
    EXPECT_EQ(life.params().gain, 0.25F);
    Life next(memory, renamed_rows(), {{kGain, 1}});
    next.start();
    EXPECT_EQ(next.params().gain, 0.25F);
    EXPECT_EQ(next.store().records(), 3U);
}

TEST(Keeper, a_value_under_the_new_name_counts_before_one_under_the_old_name) {
    Memory memory;
    keep_some(memory);
    {
        Life life(memory, renamed_rows());  // which does not know the old name
        life.start();
        life.set("wing.scale", Type::kFloat, 0.25F);
        life.run_for(10);
    }
    Life life(memory, renamed_rows(), {{kGain, 1}});
    life.start();
    life.run_for(10);
    EXPECT_EQ(life.params().gain, 0.25F);
    Life next(memory, renamed_rows(), {{kGain, 1}});
    next.start();
    EXPECT_EQ(next.params().gain, 0.25F);
}

// --- a circle of restarts ---

TEST(Keeper, after_two_short_lives_the_graphs_values_count) {
    Memory memory;
    keep_some(memory);
    {
        Life life(memory, usual_rows(), {}, 1);
        life.start();
        EXPECT_EQ(life.params().gain, 1.5F);
    }
    {
        Life life(memory, usual_rows(), {}, 2);
        life.start();
        EXPECT_EQ(life.params().gain, 0.5F);
        EXPECT_EQ(life.params().count, 4);
        EXPECT_EQ(life.report.withheld, 3);
        EXPECT_EQ(life.report.stored, 3) << "and the records stay";
        EXPECT_EQ(life.publications(), 1U) << "no node has seen one of them";
    }
    Life life(memory);
    life.start();
    EXPECT_EQ(life.params().gain, 1.5F);
}

// --- a memory that fails ---

TEST(Keeper, a_memory_that_cannot_be_read_is_told_and_not_written) {
    Memory memory;
    keep_some(memory);
    const std::vector<uint8_t> bytes = memory.bytes;
    memory.answers = false;
    Life life(memory);
    life.start();
    EXPECT_EQ(life.report.state, ParameterStatus::State::kFailed);
    EXPECT_EQ(life.set_gain(1.0F), Result::kWritten);
    life.step();
    EXPECT_EQ(life.report.refused, 1);
    EXPECT_EQ(life.report.pending, 0);
    memory.answers = true;
    life.run_for(100);
    EXPECT_EQ(memory.bytes, bytes) << "what was not loaded is not written over";
}

TEST(Keeper, a_full_memory_is_told) {
    Memory memory;
    {
        Store store(MemoryPort{&memory});
        StoredRecord record{};
        while (!store.is_loaded()) static_cast<void>(store.load_next(record));
        for (uint32_t key = 1000; key < 1000 + Store::kMaxRecords; ++key) {
            ASSERT_EQ(store.keep(drivers::nonvolatile::record_of(key, 1)), Store::Keep::kKept);
        }
    }
    Life life(memory);
    life.start();
    life.set_gain(1.0F);
    life.run_for(20);
    EXPECT_EQ(life.report.refused, 1);
    EXPECT_EQ(life.report.pending, 0);
    EXPECT_EQ(life.params().gain, 1.0F);
}

TEST(Keeper, a_write_that_fails_is_tried_again) {
    Memory memory;
    Life life(memory);
    life.start();
    life.set_gain(1.0F);
    memory.answers = false;
    life.run_for(2);
    memory.answers = true;
    life.run_for(10);
    EXPECT_EQ(life.report.pending, 0);
    EXPECT_EQ(life.report.refused, 0);
    Life next(memory);
    next.start();
    EXPECT_EQ(next.params().gain, 1.0F);
}

TEST(Keeper, a_record_that_is_lost_on_its_way_is_sent_again) {
    Memory memory;
    Life life(memory);
    life.start();
    life.loses_records = true;
    life.set_gain(1.0F);
    life.run_for(10);
    EXPECT_EQ(life.report.pending, 1);
    life.loses_records = false;
    life.run_for(60);
    EXPECT_EQ(life.report.pending, 0);
    EXPECT_EQ(life.report.stored, 1);
}

// --- power that fails ---

using Values = std::map<std::string, float>;

Values values_of(const Life& life) {
    const WingParams& params = life.params();
    return {{"count", static_cast<float>(params.count)},
            {"gain", params.gain},
            {"inverted", params.inverted ? 1.0F : 0.0F},
            {"limit", params.limit}};
}

TEST(Keeper, power_fails_after_each_byte_and_only_the_newest_change_is_in_doubt) {
    Memory kept;
    keep_some(kept);
    const auto change = [](Life& life) {
        life.set_gain(0.75F);  // a changed record
        life.run_for(3);
        life.set("wing.limit", Type::kFloat, 20.0F);  // a new one
        life.run_for(3);
        life.set("wing.count", Type::kInt32, 0.0F, 4);  // and one that is removed
        life.run_for(3);
    };
    const Values before{{"count", -2}, {"gain", 1.5F}, {"inverted", 1}, {"limit", 10}};
    std::vector<Values> possible{before};
    possible.push_back({{"count", -2}, {"gain", 0.75F}, {"inverted", 1}, {"limit", 10}});
    possible.push_back({{"count", -2}, {"gain", 0.75F}, {"inverted", 1}, {"limit", 20}});
    possible.push_back({{"count", 4}, {"gain", 0.75F}, {"inverted", 1}, {"limit", 20}});
    for (const bool spoils : {false, true}) {
        size_t reached = 0;
        for (uint64_t cut = 0; cut <= 3 * 64; ++cut) {
            Memory memory = kept;
            memory.written = 0;
            memory.cut_after = cut;
            memory.spoils_last = spoils;
            {
                Life life(memory);
                life.start();
                change(life);
            }
            memory.cut_after = Memory::kNoCut;
            Life life(memory);
            life.start();
            const Values found = values_of(life);
            const auto at = std::find(possible.begin(), possible.end(), found);
            ASSERT_NE(at, possible.end()) << cut;
            EXPECT_GE(static_cast<size_t>(at - possible.begin()), reached) << "none comes back";
            reached = static_cast<size_t>(at - possible.begin());
        }
        EXPECT_EQ(reached, 3U);
    }
}

// Random requests, starts and power cuts.
TEST(Keeper, in_500_random_histories_a_value_is_the_old_one_or_the_new_one) {
    constexpr float kLimits[]{10, 20, 30, 99.5F};
    for (uint64_t seed = 1; seed <= 500; ++seed) {
        uint64_t state = seed * 0x9E3779B97F4A7C15U;
        const auto random = [&state](uint64_t below) {  // xorshift64
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            return state % below;
        };
        Memory memory(random(2) == 0 ? 0x00 : 0xFF);
        std::optional<Values> sure;
        for (int index = 0; index < 5; ++index) {
            memory.written = 0;
            memory.cut_after = random(3) == 0 ? Memory::kNoCut : random(700);
            memory.spoils_last = random(2) == 0;
            std::vector<Values> possible;
            {
                Life life(memory);
                life.start();
                if (memory.is_cut()) continue;
                if (sure) {
                    ASSERT_EQ(values_of(life), *sure) << seed << ", life " << index;
                }
                possible.push_back(values_of(life));
                for (uint64_t i = random(8); i > 0 && !memory.is_cut(); --i) {
                    switch (random(4)) {
                        case 0:
                            life.set_gain(static_cast<float>(random(5)) * 0.5F);
                            break;
                        case 1:
                            life.set("wing.count", Type::kInt32, 0.0F,
                                     static_cast<int32_t>(random(11)) - 3);
                            break;
                        case 2:
                            life.set("wing.inverted", Type::kBool, 0.0F,
                                     static_cast<int32_t>(random(2)));
                            break;
                        default:
                            life.set("wing.limit", Type::kFloat, kLimits[random(4)]);
                    }
                    life.run_for(3);
                    if (!memory.is_cut()) possible.clear();
                    possible.push_back(values_of(life));
                }
            }
            memory.cut_after = Memory::kNoCut;
            Life life(memory);
            life.start();
            const Values found = values_of(life);
            ASSERT_NE(std::find(possible.begin(), possible.end(), found), possible.end())
                << seed << ", life " << index;
            sure = found;
        }
    }
}

}  // namespace
}  // namespace stator::apps::parameters
