!> The library itself: version, features, the last failure, and the lists of formulations and keys.
submodule (perion) perion_library
  use perion_c, only: raw_version_string => perion_version_string, &
      raw_build_info => perion_build_info, raw_has_feature => perion_has_feature, &
      raw_status_string => perion_status_string, raw_last_error => perion_last_error, &
      raw_formulation_count => perion_formulation_count, &
      raw_formulation_name => perion_formulation_name, &
      raw_formulation_description => perion_formulation_description, &
      raw_key_count => perion_key_count, raw_key_name => perion_key_name, &
      raw_key_description => perion_key_description, raw_key_default => perion_key_default, &
      raw_key_choices => perion_key_choices
  use perion_support, only: c_text, f_text
  implicit none

contains

  module procedure version_string
    text = f_text(raw_version_string())
  end procedure version_string

  module procedure build_info
    text = f_text(raw_build_info())
  end procedure build_info

  module procedure has_feature
    has = raw_has_feature(c_text(name))
  end procedure has_feature

  module procedure status_string
    text = f_text(raw_status_string(status))
  end procedure status_string

  module procedure last_error
    text = f_text(raw_last_error())
  end procedure last_error

  module procedure formulation_count
    count = int(raw_formulation_count(), c_int32_t)
  end procedure formulation_count

  module procedure key_count
    count = int(raw_key_count(), c_int32_t)
  end procedure key_count

  module procedure formulation_name_int64
    text = f_text(raw_formulation_name(before(index)))
  end procedure formulation_name_int64

  module procedure formulation_name_int32
    text = formulation_name_int64(int(index, c_int64_t))
  end procedure formulation_name_int32

  module procedure formulation_description_int64
    text = f_text(raw_formulation_description(before(index)))
  end procedure formulation_description_int64

  module procedure formulation_description_int32
    text = formulation_description_int64(int(index, c_int64_t))
  end procedure formulation_description_int32

  module procedure key_name_int64
    text = f_text(raw_key_name(before(index)))
  end procedure key_name_int64

  module procedure key_name_int32
    text = key_name_int64(int(index, c_int64_t))
  end procedure key_name_int32

  module procedure key_description_int64
    text = f_text(raw_key_description(before(index)))
  end procedure key_description_int64

  module procedure key_description_int32
    text = key_description_int64(int(index, c_int64_t))
  end procedure key_description_int32

  module procedure key_default_int64
    text = f_text(raw_key_default(before(index)))
  end procedure key_default_int64

  module procedure key_default_int32
    text = key_default_int64(int(index, c_int64_t))
  end procedure key_default_int32

  module procedure key_choices_int64
    text = f_text(raw_key_choices(before(index)))
  end procedure key_choices_int64

  module procedure key_choices_int32
    text = key_choices_int64(int(index, c_int64_t))
  end procedure key_choices_int32

  !> An index that counts from 0; what is none stays none.
  pure recursive function before(index)
    integer(c_int64_t), intent(in) :: index
    integer(c_int64_t) :: before

    before = merge(index - 1, -1_c_int64_t, index > 0)
  end function before

end submodule perion_library
