// Parameters are listed, read and set.
#include "parameter_transfer.hpp"

#include <set>
#include <string_view>

#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

using Type = ParameterValue::Type;
namespace error = mav::mav_param_error;
constexpr auto kFloat = static_cast<uint8_t>(mav::mav_param_type::kReal32);
constexpr auto kInt = static_cast<uint8_t>(mav::mav_param_type::kInt32);

class ParameterTransferTest : public MavlinkTest {
  protected:
    ParameterTransferTest() {
        parameters_ = {{"A_FLOAT", Type::kFloat, 1.5F, 0},
                       {"B_INT", Type::kInt32, 0.0F, -1},
                       {"C_BOOL", Type::kBool, 0.0F, 1},
                       {"SIXTEEN_LETTERS_", Type::kFloat, 2.0F, 0}};
    }
    static std::array<char, 16> id(std::string_view text) {
        std::array<char, 16> id{};
        std::ranges::copy(text, id.begin());
        return id;
    }
    static std::string text(const std::array<char, 16>& id) {
        return {id.begin(), std::ranges::find(id, '\0')};
    }
    void list(unsigned line = 0) {
        send(mav::ParamRequestList{.target_system = 1, .target_component = 1}, line);
    }
    void read(std::string_view name, int16_t index = -1) {
        send(mav::ParamRequestRead{
            .param_index = index, .target_system = 1, .target_component = 1, .param_id = id(name)});
    }
    void set(std::string_view name, float value, uint8_t type) {
        send(mav::ParamSet{.param_value = value,
                           .target_system = 1,
                           .target_component = 1,
                           .param_id = id(name),
                           .param_type = type});
    }
};

TEST_F(ParameterTransferTest, ListsAllInTheirOrder) {
    is_open_ = {true, true};
    list();
    list(1);
    run(1.0);
    for (unsigned line = 0; line < 2; ++line) {
        const auto values = heard<mav::ParamValue>(line);
        ASSERT_EQ(values.size(), parameters_.size());
        for (uint16_t i = 0; i < values.size(); ++i) {
            EXPECT_EQ(values[i].param_index, i);
            EXPECT_EQ(values[i].param_count, parameters_.size());
            EXPECT_EQ(text(values[i].param_id), parameters_[i].id);
        }
        EXPECT_EQ(values[0].param_type, kFloat);
        EXPECT_EQ(values[1].param_type, kInt);
        EXPECT_EQ(values[2].param_type, kInt);
        EXPECT_EQ(std::bit_cast<uint32_t>(values[1].param_value),
                  0xFFFFFFFFU);  // bits, not a number
    }
}

TEST_F(ParameterTransferTest, ReadsByIdAndByIndex) {
    read("SIXTEEN_LETTERS_");
    read("", 0);
    run(0.1);
    const auto values = heard<mav::ParamValue>();
    ASSERT_EQ(values.size(), 2U);
    EXPECT_EQ(values[0].param_index, 3);
    EXPECT_EQ(values[0].param_value, 2.0F);
    EXPECT_EQ(text(values[1].param_id), "A_FLOAT");
}

TEST_F(ParameterTransferTest, WhatThereIsNotIsAnErrorAtOnce) {
    read("NO_SUCH");
    read("", 99);
    set("NO_SUCH", 1.0F, kFloat);
    run(0.1);
    const auto errors = heard<mav::ParamError>();
    ASSERT_EQ(errors.size(), 3U);
    for (const auto& one : errors) EXPECT_EQ(one.error, error::kDoesNotExist);
    EXPECT_EQ(text(errors[0].param_id), "NO_SUCH");
    EXPECT_EQ(errors[0].target_system, kGround.system);
    EXPECT_EQ(errors[1].param_index, 99);
}

TEST_F(ParameterTransferTest, AValueThatIsSetIsToldOnAllLines) {
    is_open_ = {true, true};
    set("A_FLOAT", 2.5F, kFloat);
    set("B_INT", std::bit_cast<float>(-7), kInt);
    set("C_BOOL", std::bit_cast<float>(0), kInt);
    run(0.2);
    EXPECT_EQ(parameters_[0].real, 2.5F);
    EXPECT_EQ(parameters_[1].whole, -7);
    EXPECT_EQ(parameters_[2].whole, 0);
    EXPECT_EQ(heard<mav::ParamValue>(0).size(), 3U);
    EXPECT_EQ(heard<mav::ParamValue>(1).size(), 3U);
    EXPECT_EQ(heard<mav::ParamValue>(0).front().param_value, 2.5F);
}

TEST_F(ParameterTransferTest, AnotherTypeIsNotCast) {
    set("A_FLOAT", std::bit_cast<float>(3), kInt);
    set("B_INT", 3.0F, kFloat);
    set("B_INT", 3.0F, 1);  // uint8
    run(0.2);
    EXPECT_EQ(parameters_[0].real, 1.5F);
    EXPECT_EQ(parameters_[1].whole, -1);
    const auto errors = heard<mav::ParamError>();
    ASSERT_EQ(errors.size(), 3U);
    for (const auto& one : errors) EXPECT_EQ(one.error, error::kTypeMismatch);
    EXPECT_TRUE(heard<mav::ParamValue>().empty());
}

TEST_F(ParameterTransferTest, AStationThatKnowsAllValuesStopsTheList) {
    list();
    step();
    set("_HASH_CHECK", 0.0F, kInt);
    run(0.5);
    EXPECT_LT(heard<mav::ParamValue>().size(), parameters_.size());
    EXPECT_TRUE(heard<mav::ParamError>().empty());
}

TEST_F(ParameterTransferTest, GoesOnAfterAQuestionWithoutAnAnswer) {
    knows_parameters_ = false;
    list();
    run(0.1);
    knows_parameters_ = true;
    run(2.0);
    std::set<uint16_t> indices;
    for (const auto& value : heard<mav::ParamValue>()) indices.insert(value.param_index);
    EXPECT_EQ(indices.size(), parameters_.size());
}

TEST_F(ParameterTransferTest, AListLeavesRoomOnASlowLine) {
    line_.bytes_per_s = 1200;
    parameters_.assign(100, parameters_[0]);
    list();
    run(10.0);
    EXPECT_GE(heard(mav::Heartbeat::kId).size(), 9U);
    EXPECT_GT(heard<mav::ParamValue>().size(), 5U);
    EXPECT_LE(stations_[0].received_bytes, 13'000U);
}

}  // namespace
}  // namespace stator::apps::mavlink
