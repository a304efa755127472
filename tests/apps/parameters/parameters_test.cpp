// The node that changes parameters, called with requests; table and topics are made by hand.
#include "parameters.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string_view>

#include "stator/testing.hpp"

namespace stator::apps::parameters {
namespace {

using Action = ParameterRequest::Action;
using Result = ParameterValue::Result;
using Type = ParameterRequest::Type;

// Parameters of two nodes, as the compiler would generate them.
struct WingParams {
    uint64_t timestamp{};
    float gain{};
    int32_t count{};
    bool inverted{};
    uint8_t padding[7]{};
};
struct TailParams {
    uint64_t timestamp{};
    float gain{};
    int32_t address{};
};

constexpr ParameterRow kRows[] = {
    parameter::fixed(parameter::whole({"tail.address", "TAIL_ADDR", 5, 50}, 1,
                                      offsetof(TailParams, address), 1, 9, 1)),
    parameter::real({"tail.gain", "TAIL_GAIN", 4, 40}, 1, offsetof(TailParams, gain), 0.0F, 1.0F,
                    0.25F),
    parameter::on_ground(parameter::whole({"wing.count", "WING_COUNT", 2, 20}, 0,
                                          offsetof(WingParams, count), -3, 7, 4)),
    parameter::real({"wing.gain", "WING_GAIN", 1, 10}, 0, offsetof(WingParams, gain), 0.0F, 2.0F,
                    0.5F),
    parameter::flag({"wing.inverted", "WING_INVERTED_16", 3, 30}, 0, offsetof(WingParams, inverted),
                    false),
};

// A topic of parameters that has been published once, at the start.
template <class Params>
struct ParamsTopic : stator::testing::LoneTopic<Params> {
    explicit ParamsTopic(const Params& start) {
        Output<Params> output;
        output.connect(this->topic(), 0, false);
        output.publish([&] { return start; });
    }
};

struct ParametersTest : ::testing::Test {
    ParameterValue ask(ParameterRequest request, std::string_view name = {}) {
        for (size_t i = 0; i < name.size(); ++i) request.name[i] = static_cast<uint8_t>(name[i]);
        now_us += 1000;
        ParametersPorts ports{.now = now_us, .request = Input(request)};
        ports.parameters.connect(table, now_us);
        stator::testing::Probe value(ports.value, now_us);
        node.step(ports);
        EXPECT_EQ(value.count(), 1U) << "each request has one answer";
        return value.newest();
    }
    ParameterValue set(std::string_view name, Type type, float real, int32_t whole = 0) {
        return ask({.action = Action::kSet, .type = type, .float_value = real, .int_value = whole},
                   name);
    }

    ParamsTopic<WingParams> wing{{.gain = 0.5F, .count = 4}};
    ParamsTopic<TailParams> tail{{.gain = 0.25F, .address = 1}};
    ParameterTopic topics[2]{{&wing.topic(), true}, {&tail.topic(), true}};
    ParameterTable table{.rows = kRows, .row_count = 5, .topics = topics, .topic_count = 2};
    Parameters node;
    uint64_t now_us = 0;
};

std::string_view name_of(const ParameterValue& value) {
    return reinterpret_cast<const char*>(value.name.data());
}

TEST_F(ParametersTest, lists_all_by_index) {
    const char* const names[] = {"tail.address", "tail.gain", "wing.count", "wing.gain",
                                 "wing.inverted"};
    for (uint16_t i = 0; i < 5; ++i) {
        const ParameterValue value = ask({.index = i});
        EXPECT_EQ(value.result, Result::kRead);
        EXPECT_EQ(name_of(value), names[i]);
        EXPECT_EQ(value.index, i);
        EXPECT_EQ(value.count, 5);
    }
    const ParameterValue beyond = ask({.index = 5});
    EXPECT_EQ(beyond.result, Result::kUnknown);
    EXPECT_EQ(name_of(beyond), "");
}

TEST_F(ParametersTest, an_answer_says_what_it_answers_and_all_of_the_parameter) {
    const ParameterValue value =
        ask({.requester = ParameterRequest::Requester::kCan, .tag = 77, .index = 3}, "wing.count");
    EXPECT_EQ(value.requester, ParameterValue::Requester::kCan);
    EXPECT_EQ(value.tag, 77);
    EXPECT_EQ(value.type, ParameterValue::Type::kInt32) << "the name counts before the index";
    EXPECT_EQ(value.int_value, 4);
    EXPECT_EQ(value.int_least, -3);
    EXPECT_EQ(value.int_most, 7);
    EXPECT_EQ(value.int_default, 4);
}

TEST_F(ParametersTest, a_change_is_one_publication_of_all_parameters_of_its_node) {
    const ParameterValue value = set("wing.gain", Type::kFloat, 1.5F);
    EXPECT_EQ(value.result, Result::kWritten);
    EXPECT_EQ(value.float_value, 1.5F);
    EXPECT_EQ(value.float_default, 0.5F);
    EXPECT_EQ(wing.count(), 2U);
    EXPECT_EQ(wing.newest().timestamp, 1000U);
    EXPECT_EQ(wing.newest().gain, 1.5F);
    EXPECT_EQ(wing.newest().count, 4);
    EXPECT_EQ(tail.count(), 1U) << "of the others nothing is published";
    set("wing.count", Type::kInt32, 0.0F, -3);
    set("wing.inverted", Type::kBool, 0.0F, 1);
    EXPECT_EQ(wing.count(), 4U);
    EXPECT_EQ(wing.newest().gain, 1.5F) << "earlier changes stay";
    EXPECT_EQ(wing.newest().count, -3);
    EXPECT_TRUE(wing.newest().inverted);
}

TEST_F(ParametersTest, the_same_value_again_is_not_published) {
    EXPECT_EQ(set("wing.gain", Type::kFloat, 0.5F).result, Result::kWritten);
    EXPECT_EQ(wing.count(), 1U);
}

TEST_F(ParametersTest, what_does_not_fit_is_refused_with_the_reason) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(set("wing.gain", Type::kFloat, 2.0001F).result, Result::kOutOfRange);
    EXPECT_EQ(set("wing.gain", Type::kFloat, -kInfinity).result, Result::kOutOfRange);
    EXPECT_EQ(set("wing.gain", Type::kFloat, kNaN).result, Result::kNotANumber);
    EXPECT_EQ(set("wing.gain", Type::kInt32, 0.0F, 1).result, Result::kWrongType);
    EXPECT_EQ(set("wing.count", Type::kFloat, 1.0F, 1).result, Result::kWrongType);
    EXPECT_EQ(set("wing.count", Type::kInt32, 0.0F, 8).result, Result::kOutOfRange);
    EXPECT_EQ(set("wing.inverted", Type::kBool, 0.0F, 2).result, Result::kOutOfRange);
    EXPECT_EQ(set("wing.inverted", Type::kBool, 0.0F, -1).result, Result::kOutOfRange);
    EXPECT_EQ(set("wing.gai", Type::kFloat, 1.0F).result, Result::kUnknown);
    EXPECT_EQ(set("wing.gain2", Type::kFloat, 1.0F).result, Result::kUnknown);
    EXPECT_EQ(set("tail.address", Type::kInt32, 0.0F, 2).result, Result::kFixed);
    EXPECT_EQ(wing.count(), 1U);
    EXPECT_EQ(tail.count(), 1U);
    EXPECT_EQ(set("wing.gain", Type::kFloat, 3.0F).float_value, 0.5F) << "what counts is told";
}

TEST_F(ParametersTest, the_ends_of_a_range_belong_to_it) {
    EXPECT_EQ(set("wing.gain", Type::kFloat, 2.0F).result, Result::kWritten);
    EXPECT_EQ(set("wing.gain", Type::kFloat, 0.0F).result, Result::kWritten);
    EXPECT_EQ(set("wing.count", Type::kInt32, 0.0F, 7).result, Result::kWritten);
}

TEST_F(ParametersTest, a_name_that_fills_its_field_is_read_to_its_end) {
    EXPECT_EQ(ask({}, std::string(92, 'x')).result, Result::kUnknown);
}

TEST_F(ParametersTest, without_a_request_nothing_happens) {
    ParametersPorts ports{.now = 1000};
    ports.parameters.connect(table, 1000);
    stator::testing::Probe value(ports.value, 1000);
    node.step(ports);
    EXPECT_EQ(value.count(), 0U);
}

}  // namespace
}  // namespace stator::apps::parameters
