#pragma once
/// Key tables. Each describes the keys of a plain struct in a file. The reader with its error messages, the resolved file, the JSON Schema,
/// the reference page and the sliders of the live view use these tables. Defaults are the member initialisers of the struct.
///
///     KeyTable time_keys() {
///         KeyTableOf<TimeKeys> t("end of the run and rate of frames");
///         t.key("end", &TimeKeys::end, "s", "end of the run").required().above(0);
///         t.key("fps", &TimeKeys::fps, "1/s", "frames per second of the video").above(0).at_most(1000);
///         return t;
///     }
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "engine/core/errors.h"
#include "engine/core/types.h"

namespace whorl {

inline std::string variable_name(char letter) { return letter == 'a' ? "age" : letter == 'T' ? "temperature" : std::string(1, letter); }

/// "x, y, z, age"
inline std::string variable_names(const std::string& letters) {
    std::string all;
    for (const char c : letters) all += (all.empty() ? "" : ", ") + variable_name(c);
    return all;
}

/// A value in a file, with its location. A date has no kind (std::monostate), and no key accepts it.
struct Value {
    using List = std::vector<Value>;
    using Table = std::vector<std::pair<std::string, Value>>;  ///< entries in the order of the file
    std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Table> data;
    FileLocation place;      ///< location of the value
    FileLocation key_place;  ///< location of the key that names the value

    Value() = default;
    template <class T>
    explicit Value(T v) : data(std::move(v)) {}
    template <class T>
    const T* as() const {
        return std::get_if<T>(&data);
    }
    template <class T>
    T* as() {
        return std::get_if<T>(&data);
    }
    bool is_number() const { return as<std::int64_t>() || as<double>(); }
    double number() const { return as<double>() ? *as<double>() : static_cast<double>(*as<std::int64_t>()); }
    /// The entry of a table, nullptr if there is none.
    const Value* find(const std::string& key) const;
    Value* find(const std::string& key) { return const_cast<Value*>(std::as_const(*this).find(key)); }
    /// The value as TOML: the shortest text that reads back as the same value.
    std::string toml() const;
};

/// A key of a scene by its full name ("emitter[0].speed"), and its value. The value's `place` is the file or option that set it.
struct KeyValue {
    std::string path;
    Value value;
};

enum class KeyType { flag, integer, number, text, expression, any };

/// Meaning of a key's three entries in a 2D flow, which lies in the plane z = 0.
enum class InPlane {
    free,    ///< same as in 3D: the entries are not a vector of the flow's space
    vector,  ///< the third is 0 and may be omitted
    axis,    ///< rotation about z: only the third is used, the others must be 0
    cut      ///< position of a shape that the plane z = 0 may cut: the third may be omitted
};

/// Fault of a value of the right type (an invalid expression, for example).
struct KeyFault : std::invalid_argument {
    KeyFault(FileLocation where, const std::string& what) : std::invalid_argument(what), place(std::move(where)) {}
    FileLocation place;
};

/// Conversion between a member of type T and its value in a file. Specialise it for further types. An enum needs only a function
/// choices(E) in its namespace: `inline std::vector<std::pair<Slip, const char*>> choices(Slip) { return {{Slip::no, "no"}, {Slip::free,
/// "free"}}; }`
template <class T, class = void>
struct KeyCodec;

/// Access of a key to its member. It depends only on the member's type.
struct MemberAccess {
    Value (*write)(const void* member);
    void (*read)(void* member, const Value&);                   ///< requires a value of the right type; may throw KeyFault
    std::vector<double> (*constants)(const void* member) = {};  ///< for expressions: the values of those that are plain numbers
    std::string (*variables)(const void* member) = {};          ///< for expressions: the letters of the variables that they use
    Value (*from_text)(const Value& text) = {};                 ///< for lists that may also be given as a text: converts the text to a
                                                                ///< list; may throw KeyFault
};

struct Key {
    std::string name, unit, meaning;
    KeyType type = KeyType::number;  ///< type of the value, or of each entry of a list
    bool is_list = false;
    int count = 0;  ///< number of entries of a list; 0: any number
    InPlane in_plane = InPlane::free;
    bool may_be_auto = false;          ///< "auto" is a value (a std::optional member)
    std::vector<std::string> choices;  ///< allowed texts; empty: any text
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool least_open = false;  ///< `least` itself is not allowed
    bool single = false;      ///< stored in single precision
    std::string variables;    ///< letters of "txyz" (and 'a', age; 'T', temperature) that an expression may use
    bool is_required = false;
    bool decides = true;      ///< the simulation's result depends on this key
    bool may_change = false;  ///< may be changed during a run
    std::string selector;     ///< key that determines whether this key is used: "shape" (in the same table), "models.pressure" (from the
                              ///< root); "": always used
    std::vector<std::string> selected_by;  ///< values of the selector with which this key is used
    Value standard;                        ///< the default

    std::ptrdiff_t offset = 0;  ///< offset of the member in the object [bytes]
    const MemberAccess* access = nullptr;
    Value get(const void* object) const { return access->write(static_cast<const char*>(object) + offset); }

    /// Whether the third entry may be omitted in a 2D flow.
    bool may_lack_depth() const { return in_plane == InPlane::vector || in_plane == InPlane::cut; }
    /// The value for a 2D flow: appends a missing third entry if the key may omit it.
    Value with_depth(const Value& v) const;

    Key& required() { return is_required = true, *this; }
    Key& at_least(double v) { return least = v, *this; }
    Key& above(double v) { return least = v, least_open = true, *this; }
    Key& at_most(double v) { return most = v, *this; }
    Key& one_of(std::vector<std::string> names);
    Key& of(std::string names) { return variables = std::move(names), *this; }
    Key& only_with(std::string_view key, std::initializer_list<const char*> values);
    Key& only_with(std::string_view key, const std::vector<std::string>& values);
    Key& in(InPlane how) { return in_plane = how, *this; }
    Key& not_deciding() { return decides = false, *this; }
    Key& live() { return may_change = true, *this; }

    /// Reads v into the object's member and appends the faults of v to `problems`. @param path the key's full name, for messages
    void read(void* object, const Value& v, const std::string& path, std::vector<Problem>& problems) const;
    /// The allowed values: "more than 0, at most 1", "cubic, wendland_c2 or wendland_c4"; "" if every value of the type is allowed.
    std::string allowed() const;
    /// allowed(); if x is beyond the limits of the C++ type, these limits too.
    std::string allowed_beside(double x) const;
    /// The type as messages name it: "a number", "a list of 3 numbers", "a text", ...
    std::string type_name() const;

private:
    using Problems = std::vector<Problem>;
    void wrong_type(const FileLocation& place, const std::string& found, const std::string& path, Problems& problems) const;
    bool check_entry(const Value& entry, const std::string& path, Problems& problems) const;
    bool check_range(double x, const FileLocation& place, const std::string& path, Problems& problems) const;
    bool check_choice(const Value& entry, const std::string& path, Problems& problems) const;
    bool assign(void* object, const Value& v, const std::string& path, Problems& problems) const;
    void check_expressions(const void* object, const Value& v, const std::string& path, Problems& problems) const;
};

/// The keys of one struct, and its parts: nested structs and lists of structs, each with its own table.
class KeyTable {
public:
    struct Part {
        std::string name;  ///< [name], or [[name]] for a list
        bool is_list = false;
        bool decides = true;  ///< the simulation's result depends on this part
        std::shared_ptr<const KeyTable> table;
        std::function<void*(void* object)> one;  ///< address of the part in the object, unless the part is a list
        std::function<std::size_t(const void* object)> size;
        std::function<void*(void* object, std::size_t)> at;
        std::function<void(void* object, std::size_t)> resize;
        Part& not_deciding() { return decides = false, *this; }
    };
    std::string meaning;
    std::vector<Key> keys;
    std::vector<Part> parts;
    std::function<std::shared_ptr<void>()> make;  ///< makes a struct with all defaults

    /// Allows changes of every key of this table during a run. The tables of parts are not affected.
    void all_live() {
        for (Key& k : keys) k.live();
    }
    const Key* find_key(const std::string& name) const;
    const Part* find_part(const std::string& name) const;

protected:
    Key& add(Key key, std::string_view name, std::string_view unit, std::string_view what, const void* fresh);
};

/// The MemberAccess of a member type, shared by all keys of that type.
template <class T>
const MemberAccess* access_of() {
    using Codec = KeyCodec<T>;
    static constexpr auto made = [] {
        MemberAccess access{[](const void* member) { return Codec::write(*static_cast<const T*>(member)); },
                            [](void* member, const Value& v) { *static_cast<T*>(member) = Codec::read(v); }};
        if constexpr (requires(const T& t) { Codec::constants(t); }) {
            access.constants = [](const void* member) { return Codec::constants(*static_cast<const T*>(member)); };
            access.variables = [](const void* member) { return Codec::variables(*static_cast<const T*>(member)); };
        }
        if constexpr (requires { Codec::from_text(Value()); }) access.from_text = &Codec::from_text;
        return access;
    }();
    return &made;
}

/// Accessor of a member of a member, for key(): inside(&BlockKeys::shape, &ShapeKeys::min).
template <class S, class Inner, class T>
auto inside(Inner S::*outer, T Inner::*inner) {
    return [outer, inner](S& s) -> T& { return s.*outer.*inner; };
}

template <class S>
class KeyTableOf : public KeyTable {
public:
    explicit KeyTableOf(std::string what) {
        meaning = std::move(what);
        make = [] { return std::make_shared<S>(); };
    }

    /// @param member a member pointer, or inside() @param unit "" if dimensionless
    template <class Member>
    Key& key(std::string_view name, Member member, std::string_view unit, std::string_view what) {
        using T = std::remove_cvref_t<std::invoke_result_t<Member, S&>>;
        Key k;
        KeyCodec<T>::describe(k);
        k.offset = reinterpret_cast<const char*>(&std::invoke(member, fresh_)) - reinterpret_cast<const char*>(&fresh_);
        k.access = access_of<T>();
        return add(std::move(k), name, unit, what, &fresh_);
    }
    /// Adds a struct inside this one: [name].
    template <class T>
    Part& part(std::string name, T S::*member, KeyTable table) {
        Part p;
        p.name = std::move(name), p.table = std::make_shared<const KeyTable>(std::move(table));
        p.one = [member](void* object) -> void* { return &(static_cast<S*>(object)->*member); };
        parts.push_back(std::move(p));
        return parts.back();
    }
    /// Adds a list of structs inside this one: [[name]].
    template <class T>
    Part& list(std::string name, std::vector<T> S::*member, KeyTable table) {
        Part p;
        p.name = std::move(name), p.is_list = true, p.table = std::make_shared<const KeyTable>(std::move(table));
        p.size = [member](const void* object) { return (static_cast<const S*>(object)->*member).size(); };
        p.at = [member](void* object, std::size_t i) -> void* { return &(static_cast<S*>(object)->*member)[i]; };
        p.resize = [member](void* object, std::size_t n) { (static_cast<S*>(object)->*member).resize(n); };
        parts.push_back(std::move(p));
        return parts.back();
    }

private:
    S fresh_{};  ///< source of defaults and offsets
};

/// The shortest decimal number that reads back as v.
double shortest_decimal(float v);

template <>
struct KeyCodec<bool> {
    static void describe(Key& k) { k.type = KeyType::flag; }
    static Value write(bool v) { return Value(v); }
    static bool read(const Value& v) { return *v.as<bool>(); }
};
template <class T>
struct KeyCodec<T, std::enable_if_t<std::is_integral_v<T> && !std::is_same_v<T, bool>>> {
    static void describe(Key& k) {
        k.type = KeyType::integer;
        k.least = std::is_unsigned_v<T> ? 0 : static_cast<double>(std::numeric_limits<T>::min());
        k.most = static_cast<double>(std::numeric_limits<T>::max());
        if (sizeof(T) == 8)
            k.most = std::nextafter(k.most, 0.0);  // as a double, the maximum of a 64-bit type would round up to one
                                                   // beyond it
    }
    static Value write(T v) { return Value(static_cast<std::int64_t>(v)); }
    static T read(const Value& v) {
        const auto* whole = v.as<std::int64_t>();
        return whole ? static_cast<T>(*whole) : static_cast<T>(*v.as<double>());  // 1e3 is also a whole number
    }
};
template <class T>
struct KeyCodec<T, std::enable_if_t<std::is_floating_point_v<T>>> {
    static void describe(Key& k) { k.type = KeyType::number, k.single = std::is_same_v<T, float>; }
    static Value write(T v) {
        if constexpr (std::is_same_v<T, float>) return Value(shortest_decimal(v));
        else return Value(v);
    }
    static T read(const Value& v) { return static_cast<T>(v.number()); }
};
/// A value of any type. Another key determines the type.
template <>
struct KeyCodec<Value> {
    static void describe(Key& k) { k.type = KeyType::any; }
    static Value write(const Value& v) { return v; }
    static Value read(const Value& v) { return v; }
};
template <>
struct KeyCodec<std::string> {
    static void describe(Key& k) { k.type = KeyType::text; }
    static Value write(const std::string& v) { return Value(v); }
    static std::string read(const Value& v) { return *v.as<std::string>(); }
};
template <>
struct KeyCodec<std::filesystem::path> {
    static void describe(Key& k) { k.type = KeyType::text; }
    static Value write(const std::filesystem::path& v) { return Value(v.string()); }
    static std::filesystem::path read(const Value& v) { return *v.as<std::string>(); }
};
template <class T>
struct KeyCodec<T, std::enable_if_t<std::is_enum_v<T>>> {
    static void describe(Key& k) {
        k.type = KeyType::text;
        for (const auto& [value, name] : choices(T{})) k.choices.emplace_back(name);
    }
    static Value write(T v) {
        for (const auto& [value, name] : choices(T{}))
            if (value == v) return Value(std::string(name));
        return {};
    }
    static T read(const Value& v) {
        for (const auto& [value, name] : choices(T{}))
            if (*v.as<std::string>() == name) return value;
        return T{};
    }
};
/// A value or "auto".
template <class T>
struct OptionalCodec {
    static void describe(Key& k) { KeyCodec<T>::describe(k), k.may_be_auto = true; }
    static Value write(const std::optional<T>& v) { return v ? KeyCodec<T>::write(*v) : Value(std::string("auto")); }
    static std::optional<T> read(const Value& v) {
        if (v.as<std::string>() && *v.as<std::string>() == "auto") return {};
        return KeyCodec<T>::read(v);
    }
};

template <class T>
struct KeyCodec<std::optional<T>> : OptionalCodec<T> {};

/// Lists: a fixed number of flags or numbers, or any number of texts.
template <class L, class T, int Count>
struct ListCodec {
    static void describe(Key& k) {
        k.is_list = true, k.count = Count, k.single = std::is_same_v<T, float>;
        if constexpr (std::is_same_v<T, bool>) k.type = KeyType::flag;
        else if constexpr (std::is_integral_v<T>) k.type = KeyType::integer;
    }
    static Value write(const L& v) {
        Value::List list;
        for (int a = 0; a < Count; ++a) list.push_back(KeyCodec<T>::write(v[a]));
        return Value(std::move(list));
    }
    static L read(const Value& v) {
        L list;
        for (int a = 0; a < Count; ++a) list[a] = KeyCodec<T>::read((*v.as<Value::List>())[a]);
        return list;
    }
};
template <class T, std::size_t Count>
struct KeyCodec<std::array<T, Count>> : ListCodec<std::array<T, Count>, T, static_cast<int>(Count)> {};
template <class T>
struct KeyCodec<Eigen::Matrix<T, 3, 1>> : ListCodec<Eigen::Matrix<T, 3, 1>, T, 3> {};
/// In double precision: positions and velocities of the flow, whose third entry may be omitted in 2D. Colours and cameras, which always
/// have three entries, are in single precision.
template <>
struct KeyCodec<Vec3d> : ListCodec<Vec3d, double, 3> {
    static void describe(Key& k) { ListCodec::describe(k), k.in_plane = InPlane::vector; }
};
template <>
struct KeyCodec<std::vector<std::string>> {
    static void describe(Key& k) { k.type = KeyType::text, k.is_list = true; }
    static Value write(const std::vector<std::string>& v) {
        Value::List list;
        for (const std::string& text : v) list.emplace_back(text);
        return Value(std::move(list));
    }
    static std::vector<std::string> read(const Value& v) {
        std::vector<std::string> list;
        for (const Value& text : *v.as<Value::List>()) list.push_back(*text.as<std::string>());
        return list;
    }
};

}  // namespace whorl
