//! Faces, edges and vertices of soups whose truth is known.
