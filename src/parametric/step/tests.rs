//! Reading small files.
