// Parameters in the words of DroneCAN, and back.
#include "get_set.hpp"

#include <gtest/gtest.h>

#include <string_view>

namespace stator::apps::dronecan_node {
namespace {

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

}  // namespace
}  // namespace stator::apps::dronecan_node
