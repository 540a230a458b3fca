"""The linear map from pressures to observed motion."""
