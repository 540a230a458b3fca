#pragma once
// Each option of a struct is one line of a table: its name and the member that it is. What Python has of it is
// made from the table: keyword, type, default, attribute, repr and equality.
#include <functional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <variant>

#include "arrays.hpp"

namespace plica::python {

/// The names of a closed choice that Python writes as text: a specialisation has
///   static Named<Choice> all();
template <typename Choice>
struct Names;
template <typename Choice>
using Named = std::vector<std::pair<const char*, Choice>>;

template <typename Choice, typename = void>
constexpr bool has_names = false;
template <typename Choice>
constexpr bool has_names<Choice, std::void_t<decltype(Names<Choice>::all())>> = true;

template <typename Enum>
bool same_choice(Enum a, Enum b) {
  return a == b;
}
template <typename... Kinds>
bool same_choice(const std::variant<Kinds...>& a, const std::variant<Kinds...>& b) {
  return a.index() == b.index();
}

/// How Python gives an option and sees it: as it is, where nothing else is said.
template <typename Value, typename = void>
struct Shown {
  using Given = Value;
  static Value take(Value given, const char* /*owner*/, const char* /*option*/) { return given; }
  static Value show(const Value& value) { return value; }
  static Value initial(const Value& value) { return value; }  // the default of type Given
};

template <typename Choice>
struct Shown<Choice, std::enable_if_t<has_names<Choice>>> {
  using Given = std::string;
  static Choice take(const std::string& given, const char* owner, const char* option) {
    const auto all = Names<Choice>::all();
    std::string names;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (given == all[k].first) return all[k].second;
      names += (k == 0 ? "\"" : k + 1 == all.size() ? " or \"" : ", \"") + std::string(all[k].first) + "\"";
    }
    throw InvalidInput(std::string(owner) + ": " + option + " = \"" + given + "\"; must be " + names + ".");
  }
  static std::string show(const Choice& choice) {
    for (const auto& [name, other] : Names<Choice>::all())
      if (same_choice(choice, other)) return name;
    throw std::logic_error("a choice without a name");
  }
  static std::string initial(const Choice& choice) { return show(choice); }
};

template <>
struct Shown<Vector3> {
  using Given = std::array<double, 3>;
  static Vector3 take(const Given& v, const char*, const char*) { return {v[0], v[1], v[2]}; }
  static std::tuple<double, double, double> show(const Vector3& v) { return {v[0], v[1], v[2]}; }
  static Given initial(const Vector3& v) { return {v[0], v[1], v[2]}; }
};

/// Seen as what cannot be changed.
template <>
struct Shown<std::vector<double>> {
  using Given = std::vector<double>;
  static Given take(Given values, const char*, const char*) { return values; }
  static py::tuple show(const Given& values) { return py::tuple(py::cast(values)); }
  static Given initial(const Given& values) { return values; }
};

enum class Kind { with_default, required, taken };

/// One option: the member at the end of a path of pointers to members.
template <Kind kind_, typename... Path>
struct Option {
  static constexpr Kind kind = kind_;
  const char* name;
  std::tuple<Path...> path;

  template <typename Struct>
  auto& of(Struct& options) const {
    return std::apply(
        [&](auto... member) -> auto& { return (options.*....*member); }, path);
  }
};

template <typename... Path>
Option<Kind::with_default, Path...> option(const char* name, Path... path) {
  return {name, {path...}};
}
template <typename... Path>
Option<Kind::required, Path...> required(const char* name, Path... path) {
  return {name, {path...}};
}
/// Required, and not to be seen afterwards: large, and nothing that two of could be compared.
template <typename... Path>
Option<Kind::taken, Path...> taken(const char* name, Path... path) {
  return {name, {path...}};
}

template <typename T>
constexpr bool is_variant = false;
template <typename... Kinds>
constexpr bool is_variant<std::variant<Kinds...>> = true;

/// repr and, where all can be seen, equality and hash of a class by its attributes.
inline void describe_by(const py::object& cls, std::vector<std::string> names, bool comparable) {
  const std::string title = py::cast<std::string>(cls.attr("__name__"));
  const auto add = [&](const char* name, const auto& function) {
    cls.attr(name) = py::cpp_function(function, py::name(name), py::is_method(cls));
  };
  add("__repr__", [title, names](const py::object& self) {
    std::string text;
    for (const std::string& name : names)
      text += (text.empty() ? "" : ", ") + name + "=" + py::cast<std::string>(py::repr(self.attr(name.c_str())));
    return title + "(" + text + ")";
  });
  if (!comparable) return;
  add("__eq__", [names](const py::object& self, const py::object& other) {
    if (!py::type::of(self).is(py::type::of(other))) return false;
    for (const std::string& name : names)
      if (!self.attr(name.c_str()).equal(other.attr(name.c_str()))) return false;
    return true;
  });
  add("__hash__", [names](const py::object& self) {
    py::list values;
    for (const std::string& name : names) values.append(self.attr(name.c_str()));
    return py::hash(py::tuple(values));
  });
}

/// The options of a struct, in the order of their arguments.
template <typename Struct, typename... Options>
class OptionTable {
 public:
  explicit OptionTable(const char* name, Options... options) : name_(name), options_(options...) {}

  /// The class of the struct. `check` sees each one made and throws InvalidInput; `extra` goes before the
  /// arguments, as py::kw_only().
  template <typename... Extra>
  py::class_<Struct> bind(py::module_& engine, std::function<void(const Struct&)> check = {},
                          const Extra&... extra) const {
    py::class_<Struct> cls(engine, name_);
    std::vector<std::string> seen;
    py::dict defaults;
    const Struct initial{};
    std::apply(
        [&](const auto&... option) {
          cls.def(py::init([table = *this, check](GivenOf<Options>... given) {
                    const Struct made = table.take(std::move(given)...);
                    if (check) check(made);
                    return made;
                  }),
                  extra..., argument(option, initial)...);
          (show(option, cls, seen), ...);
          (put(option, initial, defaults), ...);
        },
        options_);
    cls.attr("_defaults") = defaults;
    describe_by(cls, seen, seen.size() == sizeof...(Options));
    return cls;
  }

  /// A function of the struct, its options as keywords.
  template <typename Function>
  void def(py::module_& engine, const char* name, const Function& function) const {
    const Struct initial{};
    std::apply(
        [&](const auto&... option) {
          engine.def(
              name,
              [table = *this, function](GivenOf<Options>... given) {
                return function(table.take(std::move(given)...));
              },
              py::kw_only(), argument(option, initial)...);
        },
        options_);
  }

  py::dict to_dict(const Struct& options) const {
    py::dict dict;
    std::apply([&](const auto&... option) { (put(option, options, dict), ...); }, options_);
    return dict;
  }

 private:
  template <typename One>
  using ShownOf = Shown<std::decay_t<decltype(std::declval<const One&>().of(std::declval<const Struct&>()))>>;
  template <typename One>
  using GivenOf = typename ShownOf<One>::Given;

  Struct take(GivenOf<Options>... given) const {
    Struct made{};
    std::apply(
        [&](const auto&... option) {
          ((option.of(made) = ShownOf<Options>::take(std::move(given), name_, option.name)), ...);
        },
        options_);
    return made;
  }

  template <typename One>
  static auto argument(const One& option, const Struct& initial) {
    if constexpr (One::kind != Kind::with_default)
      return py::arg(option.name);
    else if constexpr (is_variant<GivenOf<One>>)  // its repr is no expression that a stub could hold
      return py::arg_v(option.name, ShownOf<One>::initial(option.of(initial)), "...");
    else
      return py::arg(option.name) = ShownOf<One>::initial(option.of(initial));
  }

  template <typename One>
  static void show(const One& option, py::class_<Struct>& cls, std::vector<std::string>& seen) {
    if constexpr (One::kind != Kind::taken) {
      cls.def_property_readonly(option.name,
                                [option](const Struct& made) { return ShownOf<One>::show(option.of(made)); });
      seen.emplace_back(option.name);
    }
  }

  template <typename One>
  static void put(const One& option, const Struct& from, py::dict& dict) {
    if constexpr (One::kind == Kind::with_default) dict[option.name] = ShownOf<One>::show(option.of(from));
  }

  const char* name_;
  std::tuple<Options...> options_;
};

template <typename Struct, typename... Options>
OptionTable<Struct, Options...> options(const char* name, Options... all) {
  return OptionTable<Struct, Options...>(name, all...);
}

}  // namespace plica::python
