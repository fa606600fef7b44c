"""SegMo (Dang et al., WACV 2026): residual tokens, a masked transformer, text segments aligned with motion segments."""
