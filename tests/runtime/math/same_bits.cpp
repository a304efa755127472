// Runs every function over the same pseudo-random arguments and hashes what comes out.
#include "same_bits.hpp"

#include "stator/random.hpp"
#include "stator/rotation.hpp"
#include "stator/scalar.hpp"

namespace stator::math {
namespace {

constexpr int kCount = 20000;

// FNV-1a over 64-bit words.
class Hash {
  public:
    template <typename T>
    void add(T x) {
        value_ = (value_ ^ to_bits(canonical(x))) * 0x100000001b3u;
    }
    template <typename T>
    void add(const Quaternion<T>& q) {
        for (const T x : q.coeffs()) add(x);
    }
    template <typename T>
    void add(const Vector3<T>& v) {
        for (const T x : v) add(x);
    }
    std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 0xcbf29ce484222325u;
};

// Arguments of all kinds: any bits at all, or usual sizes.
template <typename T>
class Arguments {
  public:
    T any() {
        const std::uint64_t high = random_.word();
        const std::uint64_t low = random_.word();
        return from_bits<T>(static_cast<typename FloatFormat<T>::Bits>((high << 32) | low));
    }
    T unit() { return static_cast<T>(random_.uniform_double() * 2.0 - 1.0); }
    T mixed() {
        const std::uint32_t kind = random_.word() % 4;
        if (kind == 0) return any();
        return unit() * (kind == 1 ? T{1} : kind == 2 ? T{30} : T{10000});
    }
    Vector3<T> vector() {
        const T x = unit();
        const T y = unit();
        const T z = unit();
        return {x, y, z};
    }

  private:
    Random random_{2024};
};

template <typename T, typename Function>
std::uint64_t hash_of(Function function) {
    Arguments<T> arguments;
    Hash hash;
    for (int i = 0; i < kCount; ++i) function(arguments, hash);
    return hash.value();
}

template <typename T, typename Function>
std::uint64_t hash_of_one(Function function) {
    return hash_of<T>([=](Arguments<T>& from, Hash& hash) { hash.add(function(from.mixed())); });
}

template <typename T, typename Function>
std::uint64_t hash_of_two(Function function) {
    return hash_of<T>([=](Arguments<T>& from, Hash& hash) {
        const T x = from.mixed();
        hash.add(function(x, from.mixed()));
    });
}

template <typename T>
void hash_roundings(Arguments<T>& from, Hash& hash) {
    const T x = from.mixed();
    hash.add(floor(x));
    hash.add(ceil(x));
    hash.add(trunc(x));
    hash.add(round(x));
    hash.add(static_cast<double>(saturate<std::int32_t>(x)));
    hash.add(static_cast<double>(saturate<std::uint16_t>(x)));
}

template <typename T>
void hash_sincos(Arguments<T>& from, Hash& hash) {
    const SinCos<T> both = sincos(from.mixed());
    hash.add(both.sin);
    hash.add(both.cos);
}

template <typename T>
void hash_rotations(Arguments<T>& from, Hash& hash) {
    const Vector3<T> a = from.vector();
    const Vector3<T> b = from.vector();
    const Quaternion<T> q = from_rotation_vector(a * T{3});
    hash.add(q);
    hash.add(to_rotation_vector(q));
    hash.add(integrate(q, b, T{0.125}));
    hash.add(from_two_vectors(a, b));
    hash.add(from_matrix<T>(q.toRotationMatrix()));
    hash.add(from_body_z_and_yaw(a, b.x()));
    hash.add(heading(q));
    hash.add(tilt(q));
    const EulerAngles<T> angles = to_euler(q);
    hash.add(from_euler(angles));
    hash.add(Vector3<T>(q * b));
    hash.add(normalized(Vector3<T>(skew(a) * b)));
}

template <typename T>
void add_all(const std::string& type, std::vector<NamedHash>& out) {
    const auto add = [&](const char* name, std::uint64_t hash) {
        out.push_back({type + name, hash});
    };
    add("sqrt", hash_of_one<T>([](T x) { return sqrt(x); }));
    add("sin", hash_of_one<T>([](T x) { return sin(x); }));
    add("cos", hash_of_one<T>([](T x) { return cos(x); }));
    add("sincos", hash_of<T>(hash_sincos<T>));
    add("tan", hash_of_one<T>([](T x) { return tan(x); }));
    add("wrap_pi", hash_of_one<T>([](T x) { return wrap_pi(x); }));
    add("atan", hash_of_one<T>([](T x) { return atan(x); }));
    add("asin", hash_of_one<T>([](T x) { return asin(x); }));
    add("acos", hash_of_one<T>([](T x) { return acos(x); }));
    add("exp", hash_of_one<T>([](T x) { return exp(x); }));
    add("log", hash_of_one<T>([](T x) { return log(x); }));
    add("atan2", hash_of_two<T>([](T x, T y) { return atan2(x, y); }));
    add("pow", hash_of_two<T>([](T x, T y) { return pow(abs(x), y); }));
    add("fmod", hash_of_two<T>([](T x, T y) { return fmod(x, y); }));
    add("remainder", hash_of_two<T>([](T x, T y) { return remainder(x, y); }));
    add("rounding", hash_of<T>(hash_roundings<T>));
    add("rotation", hash_of<T>(hash_rotations<T>));
}

std::uint64_t hash_of_noise() {
    Random random(99, 3);
    Hash hash;
    for (int i = 0; i < kCount; ++i) {
        hash.add(random.uniform_float());
        hash.add(random.gaussian_float());
        hash.add(random.uniform_double());
        hash.add(random.gaussian_double());
    }
    return hash.value();
}

}  // namespace

std::vector<NamedHash> result_hashes() {
    std::vector<NamedHash> out;
    add_all<float>("float ", out);
    add_all<double>("double ", out);
    out.push_back({"noise", hash_of_noise()});
    return out;
}

}  // namespace stator::math
